"""The policy: one control step from an observation to an action."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import torch
from numpy.typing import ArrayLike
from torch import Tensor, nn

from aicon_torch.control.action_law import ActionLaw
from aicon_torch.errors import ObservationError, OptionError, choices
from aicon_torch.control.explanation import Explanation, explain
from aicon_torch.control.backward import BackwardPass
from aicon_torch.graph import WorldModel
from aicon_torch.control.observation import hold, read
from aicon_torch.quantities import PRESENT
from aicon_torch.resolution import Memory, Resolution

ACTIVE = "goals/active"
"""Key of the memory under which the factor of each goal is kept, ``(*B, goals)``."""


class Policy(nn.Module):
    """Reactive control: estimate, pull the goals' gradients back to the actuators, resolve conflicts, descend.

    All that lives from step to step is in the memory, a flat ``dict[str, Tensor]`` with leading batch dimensions: it
    goes in and comes out, can be saved with ``torch.save``, and one policy serves any number of robots.

    Args:
        model: The world model.
        resolution: What happens where gradients meet.
        law: From the gradient to the action; one for all actuators.

    Example:
        >>> action, memory = policy.predict(observation)
        >>> action, memory = policy.predict(observation, memory)
    """

    def __init__(self, model: WorldModel, resolution: Resolution, law: ActionLaw) -> None:
        super().__init__()
        self.model, self.resolution, self.law = model, resolution, law
        self.backward_pass = BackwardPass(model, resolution)
        self._memory: Memory | None = None
        flags = {name + PRESENT for name, sensor in model.sensors.items() if sensor.optional}
        self._keys = {ACTIVE, *flags, *model.quantities, *self.backward_pass.initial()}

    def predict(
        self,
        observation: Mapping[str, Any],
        state: Memory | None = None,
        episode_start: ArrayLike | Tensor | None = None,
        deterministic: bool = True,
    ) -> tuple[Any, Memory]:
        """One control step, with the signature of stable-baselines3.

        Args:
            observation: A reading for each sensor, ``(*B, size)``, numpy or torch.
            state: The memory that the last step returned; None starts an episode.
            episode_start: Rows ``(*B,)`` whose observation is the first of an episode; their memory starts anew.
            deterministic: Accepted for the signature's sake; the policy has no randomness.

        Returns:
            The action ``(*B, size)``, of the observation's kind (a dict of them if there are several actuators), and
            the memory.

        Raises:
            ObservationError: If a reading is missing, wrongly shaped, NaN or infinite. Tensors are not checked for
                NaN and infinity, so that nothing waits for the device.
        """
        with torch.inference_mode(False):
            before, readings = self._begin(observation, state, episode_start)
            commands, memory = self._step(readings, before)
        actions: dict[str, Any] = commands
        if not any(isinstance(reading, Tensor) for reading in observation.values()):
            actions = {name: action.numpy(force=True).astype(np.float32) for name, action in actions.items()}
        return (next(iter(actions.values())) if len(actions) == 1 else actions), memory

    @torch.enable_grad()
    def _step(self, readings: Mapping[str, Tensor], before: Memory) -> tuple[dict[str, Tensor], Memory]:
        """Estimate, pull back, resolve, act: the commands by actuator, and the memory."""
        values, tapes = self.model.step(self._values(readings, before))
        gradients, meetings = self.backward_pass(tapes, values, before, before[ACTIVE])
        for name, actuator in self.model.actuators.items():
            values[name] = self.law(gradients[name], values[name], actuator, self.model.dt)
            values[name] = self.model.constrain(name, values)
        return self.model.commands(values), {**values, **meetings, ACTIVE: before[ACTIVE]}

    def estimate(
        self,
        observation: Mapping[str, Any],
        state: Memory | None = None,
        action: Mapping[str, Tensor] | None = None,
        episode_start: ArrayLike | Tensor | None = None,
    ) -> Memory:
        """Update the estimates alone, while somebody else acts.

        Args:
            observation: As for :meth:`predict`.
            state: The memory that the last step returned.
            action: What was executed since, by actuator, ``(*B, size)``; by default the action in the memory.
            episode_start: As for :meth:`predict`.
        """
        action = action or {}
        for name, executed in action.items():
            if name not in self.model.actuators:
                raise OptionError(f"No actuator is named {name!r}. Actuators: {choices(self.model.actuators)}.")
            size = self.model.actuators[name].size
            if executed.shape[-1:] != (size,) or not executed.isfinite().all():
                raise ObservationError(f"action of {name!r}: expected finite values of shape (*batch, {size}).")
        with torch.inference_mode(False):
            before, readings = self._begin(observation, state, episode_start)
            values, _ = self.model.step(self._values(readings, before) | dict(action), differentiable=False)
        return before | values

    def compile(self) -> "Policy":  # type: ignore[override]  # nn.Module compiles in place and is called in silence
        """The same policy with its step compiled: see :class:`aicon_torch.control.compiled.CompiledPolicy`."""
        from aicon_torch.control.compiled import CompiledPolicy  # loads the compiler

        return CompiledPolicy(self)

    def reset(self) -> None:
        """Forget the memory that :meth:`act` keeps."""
        self._memory = None

    def act(self, observation: Mapping[str, Any]) -> Any:
        """One control step of a single episode, with the memory kept here: :meth:`predict` for those in a hurry."""
        action, self._memory = self.predict(observation, self._memory)
        return action

    def switch(self, memory: Memory, **goals: bool | float | Tensor) -> Memory:
        """The memory with goals switched on or off, or weighted, which outlasts the episode.

        Args:
            memory: The memory to start from.
            **goals: For each goal to change its factor, a number or ``(*B,)``.
        """
        active = memory[ACTIVE].clone()
        for name, factor in goals.items():
            if name not in self.model.goals:
                raise OptionError(f"No goal is named {name!r}. Goals: {choices(self.model.goals)}.")
            active[..., list(self.model.goals).index(name)] = torch.as_tensor(factor, dtype=active.dtype)
        return memory | {ACTIVE: active}

    def explain(self, memory: Memory, row: int | tuple[int, ...] = ()) -> Explanation:
        """What the step that returned this memory decided, in numbers.

        Args:
            memory: The memory.
            row: Which row of the batch.
        """
        return explain(self.backward_pass, memory, row)

    def _begin(
        self, observation: Mapping[str, Any], state: Memory | None, episode_start: ArrayLike | Tensor | None
    ) -> tuple[Memory, dict[str, Tensor]]:
        """The memory with the rows that start anew, and the new readings."""
        readings = read(observation, self.model.sensors, self.model.like)
        batch = tuple(next(iter(readings.values())).shape[:-1])
        if state is None:
            self._check_first(observation, readings, None)
            readings = hold(readings, self.model.sensors)
            before = self._initial(readings, batch)
        else:
            if state.keys() != self._keys:
                missing, more = self._keys - state.keys(), state.keys() - self._keys
                raise ObservationError(
                    f"state: not a memory of this policy; it lacks {choices(missing)} and has {choices(more)} besides."
                )
            there = tuple(state[next(iter(self.model.actuators))].shape[:-1])
            if there != batch:
                raise ObservationError(
                    f"state: its batch is {there}, that of the observation {batch}; expected the same."
                )
            start = self._starts(episode_start, batch)
            if start is not None:
                self._check_first(observation, readings, start)
            readings = hold(readings, self.model.sensors, state, start)
            before = state
            if start is not None:
                fresh = self._initial(readings, batch)
                rows = {key: start[(..., *(None,) * (value.dim() - start.dim()))] for key, value in state.items()}
                before = {key: torch.where(rows[key], fresh[key], value) for key, value in state.items()}
                before[ACTIVE] = state[ACTIVE]  # a setting, no estimate
        return before, readings

    def _values(self, readings: Mapping[str, Tensor], before: Memory) -> dict[str, Tensor]:
        """The last estimates and actions, with the new readings."""
        return {**{name: before[name] for name in self.model.quantities}, **readings}

    def _check_first(
        self, observation: Mapping[str, Any], readings: Mapping[str, Tensor], start: Tensor | None
    ) -> None:
        """An estimate that starts at a reading needs one in the first observation; tensors are not checked."""
        for name in self.model.first_readings:
            key = self.model.sensors[name].key or name
            if isinstance(observation.get(key), Tensor):
                continue
            absent = ~readings[name].isfinite().all(-1)
            if (absent if start is None else absent & start).any():
                raise ObservationError(
                    f"Sensor {name!r}: an episode's first observation must have a reading under {key!r}, where an "
                    f"estimate starts; it has {choices(observation)}."
                )

    def _starts(self, episode_start: ArrayLike | Tensor | None, batch: tuple[int, ...]) -> Tensor | None:
        """The rows that start anew, ``(*B,)``; None if there are none."""
        if episode_start is None or isinstance(episode_start, Tensor):
            return episode_start
        rows = np.asarray(episode_start, dtype=bool)
        if rows.shape != batch and rows.size != 1:
            raise ObservationError(f"episode_start: expected shape {batch}, the batch, got {rows.shape}.")
        if not rows.any():
            return None
        whole = np.broadcast_to(rows.reshape(-1)[0] if rows.size == 1 else rows, batch)
        return torch.as_tensor(whole.copy(), device=self.model.like.device)

    def _initial(self, readings: dict[str, Tensor], batch: tuple[int, ...]) -> Memory:
        like = self.model.like
        state = self.backward_pass.initial() | {ACTIVE: torch.ones(len(self.model.goals))}
        state = {key: v.to(like.device, like.dtype if v.is_floating_point() else v.dtype) for key, v in state.items()}
        return self.model.initial(readings, batch) | {key: v.expand((*batch, *v.shape)) for key, v in state.items()}
