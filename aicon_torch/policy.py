"""The policy: from an observation to an action, one control step at a time."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Self, cast

import numpy as np
import torch
from numpy.typing import ArrayLike
from torch import Tensor, nn

from aicon_torch.control.action_law import ActionLaw
from aicon_torch.control.backward import BackwardPass
from aicon_torch.control.foresight import Foresight
from aicon_torch.control.memory import (
    GOAL_FACTORS,
    checked_memory,
    grown,
    integer_types,
    lasting,
    memory_shapes,
    starting_rows,
)
from aicon_torch.control.step import ControlStep
from aicon_torch.differentiation import learns, through_time, undisturbed
from aicon_torch.errors import ObservationError, OptionError, choices
from aicon_torch.estimation import Estimator
from aicon_torch.export.exported_policy import ExportedPolicy
from aicon_torch.export.native import NativeSteps
from aicon_torch.goals import Goal, factor_of
from aicon_torch.graph import Filtered, Information, WorldModel
from aicon_torch.graph.build import check_modes
from aicon_torch.graph.checks import check_mode
from aicon_torch.inspection.explanation import Explanation, explain
from aicon_torch.inspection.trace import StepTrace, trace
from aicon_torch.quantities import Sensor
from aicon_torch.readings.observation import as_tensor, read
from aicon_torch.readings.perception import Perception
from aicon_torch.readings.validation import BEGINS
from aicon_torch.resolution import Memory, NullspaceProjection, Resolution
from aicon_torch.safety.watchdog import keep_finite
from aicon_torch.validation import check_function, check_instance


class Policy(nn.Module):
    """Reactive control: estimate, pull the goals' gradients back to the actuators, descend.

    All that lives from step to step is in the memory, a flat ``dict[str, Tensor]`` with leading
    batch dimensions. It goes in and comes out, can be saved with ``torch.save``, and one policy
    serves any number of robots.

    Args:
        model: The world model.
        resolution: What happens where gradients meet; by default nullspace projection as shipped.
        law: From the gradient to the action, one for all actuators; by default full speed along it.
        perception: What makes readings of raw observations such as images, if anything has to.

    Raises:
        OptionError: If one of them is something else, or the resolution names an unknown goal.
        GraphError: If only safety goals depend on an actuator: a :class:`aicon_torch.Shield` keeps
            those while another policy acts.

    Example:
        >>> action, memory = policy.predict(observation)
        >>> action, memory = policy.predict(observation, memory)
    """

    def __init__(
        self,
        model: WorldModel,
        resolution: Resolution | None = None,
        law: ActionLaw | None = None,
        perception: Perception | None = None,
    ) -> None:
        super().__init__()
        self.model = model
        self.resolution = NullspaceProjection() if resolution is None else resolution
        self.law = Foresight() if law is None else law
        self.perception = perception
        check_instance(self, ("model",), WorldModel, "WorldModel(sensors=..., goals=...)")
        check_instance(self, ("resolution",), Resolution, "NullspaceProjection()")
        check_instance(self, ("law",), ActionLaw, "Foresight()")
        _check_no_parameters("resolution", self.resolution)
        _check_no_parameters("law", self.law)
        if perception is not None:
            check_function(self, ("perception",), "(observation, values, starts)")
        if isinstance(perception, nn.Module):
            check_mode("perception", perception)
        for name, actuator in model.actuators.items():
            self.law.check(name, actuator)

        self.backward_pass = BackwardPass(model, self.resolution)
        self._step = ControlStep(model, self.backward_pass, self.law)
        self._shapes = memory_shapes(self.backward_pass, self._step.validate)
        self._integers = integer_types(self.backward_pass, self._step.validate)
        self._made_of: tuple[dict[str, tuple[int, ...]], ...] = ()  # shapes of memories that go on
        self._memory: Memory | None = None
        self._native: NativeSteps | None = None

    def predict(
        self,
        observation: Mapping[str, Any],
        state: Memory | None = None,
        episode_start: ArrayLike | Tensor | None = None,
        deterministic: bool = True,
        create_graph: bool = False,
    ) -> tuple[Any, Memory]:
        """One control step, with the signature of stable-baselines3.

        Args:
            observation: A reading for each sensor, ``(*B, size)``, numpy or torch.
            state: The memory that the last step returned; None starts an episode.
            episode_start: Rows ``(*B,)`` whose observation is the first of an episode; their memory
                starts anew.
            deterministic: Accepted for the signature's sake; the policy has no randomness.
            create_graph: Whether action and memory are to be differentiable by what learns, and by
                the memory that went in, not by the observation: for imitation, and for search
                through the model's own prediction. The action is the same but for rounding.
                Ranks, switches and gates of the mechanism are constants of the step.

        Returns:
            The action ``(*B, size)`` (a dict of them if there are several actuators), and the
            memory. It is a tensor where this observation holds a tensor, whatever earlier ones
            held, and a numpy array of float32 where it holds none, such as an empty one.

        Raises:
            ObservationError: If the key of a sensor that is not optional is missing, or a reading
                is wrongly shaped, not real or not dense. A number that is masked, not finite or
                beyond the sensor's range is no error but no reading, in its row alone.
        """
        if create_graph:
            readable = self if self._native is None else self._readable()
            with through_time():
                return readable.predict(observation, state, episode_start)
        native = None if self._native is None else self._native.of(self._step, self.perception)
        if native is not None:
            # The memory of a policy with less in it goes on by a readable step: it is but one.
            if self._earlier(state) is not None:
                return self._readable().predict(observation, state, episode_start)
            action, after = native.predict(observation, state, episode_start)
            return action, cast(Memory, after)  # it is read like one

        seen = self._perceived(observation, state, episode_start)
        with undisturbed(self.model.like):
            memory, readings = self._begin(seen, state, episode_start)
            commands, memory = self._step(readings, memory)

        # An action is of the observation's kind, and alone where there is one actuator.
        takes_tensors = any(isinstance(reading, Tensor) for reading in observation.values())
        takes_tensors = takes_tensors or learns()
        actions = commands if takes_tensors else _as_numpy(commands)
        if len(actions) == 1:
            return next(iter(actions.values())), memory
        return actions, memory

    def estimate(
        self,
        observation: Mapping[str, Any],
        state: Memory | None = None,
        action: Mapping[str, Any] | ArrayLike | Tensor | None = None,
        episode_start: ArrayLike | Tensor | None = None,
    ) -> Memory:
        """Update the estimates alone, while somebody else acts.

        Args:
            observation: As for :meth:`predict`.
            state: The memory that the last step returned.
            action: What was executed since, by actuator, ``(*B, size)``, or that alone where there
                is one actuator; by default the action in the memory.
            episode_start: As for :meth:`predict`.

        Raises:
            OptionError: If there is no such actuator.
            ObservationError: If the action has another shape, or is not finite.
        """
        seen = self._perceived(observation, state, episode_start)
        with undisturbed(self.model.like):
            memory, readings = self._begin(seen, state, episode_start)

            # What somebody else did takes the place of the action in the memory.
            executed = self._checked_actions(action, tuple(memory[BEGINS].shape))
            values = lasting(self.model, self._step.estimate(memory, readings, executed))
            _, kept = keep_finite(self.model, {}, values, memory)
        return memory | kept

    def learn(self, *names: str, start: Mapping[str, Any] | None = None) -> "Policy":
        """A copy of this policy of which some numbers learn: see :meth:`WorldModel.learn`.

        Args:
            *names: The names of the numbers, of ``policy.model.numbers``.
            start: Where some of them start, if not where they are.

        Raises:
            GraphError: As for the model.

        Example:
            >>> learner = policy.learn("x_pose.predict.radius", "x_pose.noise")
            >>> optimizer = torch.optim.Adam(learner.parameters(), lr=0.05)
            >>> loss = -learner.filter(observations, {"a": actions}).log_likelihood().mean()
        """
        model = self.model.learn(*names, start=start)
        return Policy(model, self.resolution, self.law, self.perception)

    def train(self, mode: bool = True) -> Self:
        """Put it into training mode: see :meth:`WorldModel.train`.

        Args:
            mode: Whether it is training mode.

        Raises:
            GraphError: As for the model, and for the perception.
        """
        if mode:
            check_modes(self.model.declaration, trains=True)
        if mode and isinstance(self.perception, nn.Module):
            check_mode("perception", self.perception, trains=True)
        return super().train(mode)

    def filter(
        self,
        observations: Mapping[str, Any],
        actions: Mapping[str, Tensor],
        truncate: int | None = None,
    ) -> Filtered:
        """Filter a log of observations, differentiably: see :meth:`WorldModel.filter`.

        Args:
            observations: As for :meth:`predict`, but of T steps, ``(*B, T, size)``; what a
                perception makes of raw ones.
            actions: As for the model: each actuator's, ``(*B, T, size)``, as the memory holds it.
            truncate: As for the model.

        Raises:
            ObservationError: As for :meth:`predict`, and for the model.
        """
        model = self.model
        readings = read(observations, model.sensors, {}, model.like)
        return model.filter(readings, actions, truncate)

    def information(
        self, observations: Mapping[str, Any], actions: Mapping[str, Tensor]
    ) -> Information:
        """What a log tells of each number that learns: see :meth:`WorldModel.information`.

        Args:
            observations: As for :meth:`filter`.
            actions: As for :meth:`filter`.

        Raises:
            ObservationError: As for :meth:`filter`.
        """
        readings = read(observations, self.model.sensors, {}, self.model.like)
        return self.model.information(readings, actions)

    def named_parameters(self, *args: Any, **kwargs: Any) -> Iterator[tuple[str, nn.Parameter]]:
        """Those that are learned: see :meth:`learn`. No gradient reaches those of a perception."""
        learning = set(self.model.parameters())
        for name, parameter in super().named_parameters(*args, **kwargs):
            if parameter in learning:
                yield name, parameter

    def _readable(self) -> "Policy":
        """This policy uncompiled."""
        policy = Policy(self.model, self.resolution, self.law, self.perception)
        policy._made_of = self._made_of
        return policy

    def compile(self) -> "Policy":  # type: ignore[override]  # torch's compiles in place and in silence
        """The same policy with its step compiled, a hundred times faster.

        On the CPU the step is translated to C, as :meth:`export` does it; the memory is then read
        like a dictionary, and is one array. Elsewhere, or where an operation has no translation,
        which is then logged as a warning by its name, TorchInductor compiles it: see
        :class:`aicon_torch.export.inductor.CompiledStep`. Where a parameter has changed, call it
        again.
        """
        from aicon_torch.export.inductor import CompiledStep  # loads the compiler

        compiled = self._readable()
        compiled._step = CompiledStep(compiled._step)
        compiled._native = NativeSteps()
        return compiled

    def with_goal(self, goal: Goal) -> "Policy":
        """This policy with a goal more, compiled if this one is.

        A memory of this policy goes on in the new one: give it to :meth:`predict` as ever. What it
        knows it goes on to know, and a goal that is switched off stays off.

        Args:
            goal: The goal.

        Raises:
            GraphError: As for a model that is built.

        Example:
            >>> policy = policy.with_goal(Goal("stay dry", near_the_puddle))
            >>> action, memory = policy.predict(observation, memory)
        """
        return self._grown(self.model.with_goal(goal))

    def with_estimator(self, estimator: Estimator, /, **sensors: Sensor) -> "Policy":
        """This policy with an estimator more, and the sensors that it reads: see :meth:`with_goal`.

        It begins with the readings of the first step that is taken with it. A row that lacks one
        that its prior reads rests until it comes, and then begins anew.

        Args:
            estimator: The estimator.
            **sensors: Sensors by name that are new with it.

        Raises:
            GraphError: As for a model that is built.

        Example:
            >>> ball = moving_point("x_ball", "z_ball", dt=0.02)
            >>> policy = policy.with_estimator(ball, z_ball=Sensor(3, "m", key="ball"))
        """
        return self._grown(self.model.with_estimator(estimator, **sensors))

    def export(self, path: str | Path, target: str | None = None, **description: str) -> None:
        """Write the control step to a file that runs without torch, in microseconds.

        What is in it, down to the reading of observations and the beginning of episodes, is plain C
        without allocations: :func:`aicon_torch.load_exported` runs it in Python, ``examples/cpp``
        in C++ and ``examples/web`` in a web page. A perception is not in it.

        Args:
            path: A file that ends in ``.so``, for a library compiled for this kind of machine, in
                ``.wasm``, for a module that runs in web pages, or in ``.c``, for its source; with a
                target in ``.so``, ``.dylib``, ``.dll`` or ``.wasm``, as libraries do there.
            target: Another machine that it shall run on: ``"x86_64-linux"``, ``"aarch64-linux"``,
                ``"armv7-linux"``, ``"riscv64-linux"``, ``"x86_64-macos"``, ``"aarch64-macos"``,
                ``"x86_64-windows"`` or ``"wasm32-web"``, which needs no naming. It needs nothing
                there, and ziglang here (``pip install 'aicon-torch[compiler]'``).
            **description: What is to be known of it, such as ``task="pusht"``.

        Raises:
            OptionError: If the file's name ends otherwise, it cannot be written there, or there is
                no such target or no C compiler.
            GraphError: If an operation has no translation to C.
        """
        from aicon_torch.export.exporting import export  # loads the translation to C

        step = ControlStep(self.model, self.backward_pass, self.law)
        with undisturbed(self.model.like), torch.enable_grad():
            export(step, path, description, self.perception is not None, target)

    def is_exported(self, exported: ExportedPolicy) -> bool:
        """Whether an exported policy has this one's parameters, as they are now."""
        from aicon_torch.export.exporting import parameters_of  # loads the translation to C

        same: bool = exported.metadata.get("parameters", "") == parameters_of(self.model)
        return same

    def reset(self) -> None:
        """Forget the memory that :meth:`act` keeps."""
        self._memory = None

    def act(self, observation: Mapping[str, Any]) -> Any:
        """One control step of a single episode, with the memory kept here: for those in a hurry."""
        action, self._memory = self.predict(observation, self._memory)
        return action

    def switch(self, memory: Memory, **goals: bool | float | Tensor) -> Memory:
        """The memory with goals switched on or off, or weighted, which outlasts the episode.

        Args:
            memory: The memory to start from.
            **goals: For each goal to change its factor, a number >= 0 or ``(*B,)`` of them.

        Raises:
            OptionError: If there is no such goal, or a factor is none.
            ObservationError: If it is no memory of this policy, or one of a policy that this one
                was made of.
        """
        names = list(self.model.goals)
        if self._earlier(memory) is not None:
            raise ObservationError(
                "state: a memory of the policy that this one was made of; take a step with it "
                "first."
            )

        # A copy: the memory that was given stays what it is.
        memory = self._own(memory)
        factors = memory[GOAL_FACTORS].clone()
        for name, factor in goals.items():
            if name not in names:
                raise OptionError(f"No goal is named {name!r}. Goals: {choices(names)}.")
            factors[..., names.index(name)] = factor_of(name, factor, factors)
        return memory | {GOAL_FACTORS: factors}

    def trace(self, memory: Memory) -> StepTrace:
        """What the step that returned this memory knew and decided, for every row of the batch.

        Args:
            memory: The memory.

        Raises:
            ObservationError: If it is no memory of this policy.
        """
        with undisturbed(self.model.like):
            return trace(self.backward_pass, self._own(memory))

    def explain(self, memory: Memory, row: int | tuple[int, ...] = ()) -> Explanation:
        """What the step that returned this memory decided, in numbers to read.

        Args:
            memory: The memory.
            row: Which row of the batch.

        Raises:
            ObservationError: If it is no memory of this policy.
            ValueError: If there is no such row.
        """
        with undisturbed(self.model.like):
            return explain(self.backward_pass, self._own(memory), row)

    def _begin(
        self,
        observation: Mapping[str, Any],
        state: Memory | None,
        episode_start: ArrayLike | Tensor | None,
    ) -> tuple[Memory, dict[str, Tensor]]:
        """The memory with the rows that start anew, and the new readings."""
        model = self.model
        readings = read(observation, model.sensors, model.actuators, model.like)
        batch = tuple(readings[next(iter(model.sensors))].shape[:-1])

        # An episode of all rows begins.
        if state is None:
            (fresh,) = self._step.start(readings)
            return fresh, readings

        # The memory of a policy with less in it goes on.
        shapes = self._earlier(state)
        state = self._known(state, batch)
        if shapes is not None:
            state = self._grown_memory(state, shapes, readings)

        # Some rows begin, and some wait for the reading that they begin with.
        starts = starting_rows(episode_start, batch, model.like.device)
        return self._step.restarted(state, readings, starts), readings

    def _own(self, memory: Memory) -> Memory:
        """A memory that a step of this policy returned, in its precision."""
        return checked_memory(memory, self._shapes, self._integers, self.model.like)

    def _known(self, state: Memory, batch: tuple[int, ...] | None = None) -> Memory:
        """A memory of this policy, or of one that it was made of, in the precision of this one."""
        shapes = self._earlier(state)
        expected = self._shapes if shapes is None else shapes
        return checked_memory(state, expected, self._integers, self.model.like, batch)

    def _grown(self, model: WorldModel) -> "Policy":
        """This policy with more in its model."""
        policy = Policy(model, self.resolution, self.law, self.perception)

        # Memories of this policy go on in the new one, and so do those that go on in this one.
        policy._made_of = (*self._made_of, self._shapes)
        if self._native is not None:
            policy = policy.compile()
        policy._memory = self._memory
        return policy

    def _earlier(self, state: Memory | None) -> dict[str, tuple[int, ...]] | None:
        """The shapes of a memory of a policy that this one was made of; None for any other."""
        if not isinstance(state, Mapping):
            return None
        for shapes in self._made_of:
            # A goal more may leave the keys as they are; the goals' factors are one longer then.
            has_keys = state.keys() == shapes.keys()
            if has_keys and tuple(state[GOAL_FACTORS].shape[-1:]) == shapes[GOAL_FACTORS]:
                return shapes
        return None

    def _grown_memory(
        self,
        state: Memory,
        shapes: Mapping[str, tuple[int, ...]],
        readings: Mapping[str, Tensor],
    ) -> Memory:
        """A memory of a policy that this one was made of, as it goes on here."""
        (fresh,) = self._step.start(readings)

        # What begins with a reading waits for it, row by row.
        lacks = torch.zeros_like(state[BEGINS])
        for name in self.model.graph.first_readings:
            if name not in shapes:
                lacks = lacks | ~readings[name].isfinite().all(-1)
        return grown(state, fresh, lacks)

    def _perceived(
        self,
        observation: Mapping[str, Any],
        state: Memory | None,
        episode_start: ArrayLike | Tensor | None,
    ) -> Mapping[str, Any]:
        """The observation with what the perception makes of it."""
        if self.perception is None:
            return observation
        if state is None:
            return self.perception(observation, None, None)

        # The memory of a policy that this one was made of lacks what is new.
        known = self._known(state)
        values = {name: known[name] for name in self.model.quantities if name in known}
        batch = tuple(known[BEGINS].shape)
        starts = starting_rows(episode_start, batch, self.model.like.device)
        flags = None if starts is None else starts.numpy(force=True)
        return self.perception(observation, values, flags)

    def _checked_actions(self, actions: Any, batch: tuple[int, ...]) -> dict[str, Tensor]:
        """What somebody else did, ``(*B, size)``, of the model's type."""
        # One actuator needs no name, as in what predict returns.
        if actions is None:
            actions = {}
        if not isinstance(actions, Mapping):
            if len(self.model.actuators) != 1:
                raise OptionError(
                    f"action: expected what was executed by actuator "
                    f"({choices(self.model.actuators)}), got {type(actions).__name__}."
                )
            actions = {next(iter(self.model.actuators)): actions}

        executed: dict[str, Tensor] = {}
        for name, given in actions.items():
            if name not in self.model.actuators:
                raise OptionError(
                    f"No actuator is named {name!r}. Actuators: {choices(self.model.actuators)}."
                )

            actuator = self.model.actuators[name]
            action = as_tensor(f"action of {name!r}", actuator.unit, given, self.model.like)
            shape = (*batch, actuator.size)
            if tuple(action.shape) != shape or not action.isfinite().all():
                raise ObservationError(
                    f"action of {name!r}: expected finite values of shape {shape}, got {given!r}."
                )
            executed[name] = action
        return executed


def _check_no_parameters(name: str, part: Resolution | ActionLaw) -> None:
    """Check that a part of the mechanism has nothing to learn.

    Raises:
        OptionError: If it is a module with parameters.
    """
    found = [called for called, _ in part.named_parameters()] if isinstance(part, nn.Module) else []
    if found:
        raise OptionError(
            f"{name}={type(part).__name__}(...) has parameters ({choices(found)}), and only the "
            "numbers and networks of the model learn: make them constants."
        )


def _as_numpy(commands: Mapping[str, Tensor]) -> dict[str, Any]:
    """Commands as Gymnasium's environments take them."""
    return {
        name: command.numpy(force=True).astype(np.float32) for name, command in commands.items()
    }
