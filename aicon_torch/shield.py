"""A shield: somebody else's policy, within bounds that nothing violates."""

import copy
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import torch
from numpy.typing import ArrayLike
from torch import Tensor

from aicon_torch.control import DirectDescent
from aicon_torch.dampers import WayAround
from aicon_torch.differentiation import stop
from aicon_torch.errors import GraphError, ObservationError, OptionError, choices
from aicon_torch.estimation import Deterministic
from aicon_torch.goals import Goal
from aicon_torch.graph import WorldModel
from aicon_torch.inspection.shielding import Shielding, shielding
from aicon_torch.inspection.trace import StepTrace
from aicon_torch.interconnections import Interconnection, Values
from aicon_torch.policy import Policy
from aicon_torch.quantities import PRESENT, Sensor
from aicon_torch.readings.observation import as_array, as_tensor
from aicon_torch.resolution import Memory
from aicon_torch.validation import check_flag

PROPOSAL = "proposal"
"""The sensor, and the observation's key, of what is proposed."""

NOMINAL = "x_proposal"
"""The estimate of it as an action of the actuator: at rest where nothing is proposed."""


class ShieldState(NamedTuple):
    """What lives from step to step.

    ``torch.save`` writes it, and ``torch.load`` reads it again, as far as it reads the state of the
    policy within: tensors, and what Python itself is made of.

    Attributes:
        memory: Of the shield.
        inner: The state of the policy within.
    """

    memory: Memory
    inner: Any


torch.serialization.add_safe_globals([ShieldState])


class Shield:
    """A policy that does what another one proposes, as far as the safety goals of a graph allow.

    What is proposed, w, is read by the graph like a sensor, and to act accordingly is its goal,
    g = −a·w. Its gradient −w makes the nominal action w itself, and of all actions that keep the
    safety goals the nearest is taken. Where they bring to rest what w asks for, that is a conflict,
    and explored: see :class:`aicon_torch.safety.way_around.Around`.

    A row with a number that is not finite, or masked, is no proposal, as it would be no reading:
    what is left of it might point anywhere. It asks for rest, whatever ``nominal`` is, and bounds
    that have to grow move the robot as ever. An episode begins with its first proposal.

    It is a policy like any other: batched, and compiled; what it exports reads the proposal as a
    part of the observation, by the same rule.

    Args:
        policy: Anything with the ``predict`` of stable-baselines3, or a function of the
            observation, that proposes actions ``(*B, size)``. The shield has copies of what its
            sensors read, which stay as they are whatever the policy does to the observation.
        model: The graph: sensors, one actuator with a finite limit, estimators, safety goals. What
            its other goals want is left out, so that it may be that of a policy.
        nominal: Where proposals are no actions of the actuator, such as places to go to: a function
            of ``proposal`` and any quantities, wired by its parameters' names, that returns the
            action ``(*B, size)`` that is meant. (``Actuator(command=)`` is the way back.)
        size: Number of components of a proposal; by default the actuator's.
        goes_around: Whether it goes around what holds it up, or stays there.

    Raises:
        GraphError: If the model has another number of actuators than one, no safety goal that
            bounds it, or one of the names that the shield adds, or nominal reads no proposal.
        OptionError: If the policy proposes nothing, the model or nominal is none, or goes_around is
            neither True nor False.

    Example:
        >>> shield = Shield(PPO.load("agent.zip"), WorldModel(...))
        >>> action, state = shield.predict(observation)
        >>> action, state = shield.predict(observation, state)
        >>> print(shield.explain(state))
    """

    def __init__(
        self,
        policy: Any,
        model: WorldModel,
        nominal: Callable[..., Tensor] | None = None,
        size: int | None = None,
        goes_around: bool = True,
    ) -> None:
        if isinstance(policy, type) or not callable(getattr(policy, "predict", policy)):
            raise OptionError(f"policy={policy!r}: expected something with predict, or a function.")
        check_flag("goes_around", goes_around)
        self.inner = policy
        following = _following(model, nominal, size, goes_around)
        self.policy = Policy(following, law=DirectDescent(gain=1.0, smoothing=0.0))
        self._keys = _keys_of(following)
        self._state: ShieldState | None = None

    @property
    def model(self) -> WorldModel:
        """The graph, with the proposal in it."""
        return self.policy.model

    def predict(
        self,
        observation: Mapping[str, Any],
        state: ShieldState | None = None,
        episode_start: ArrayLike | Tensor | None = None,
        deterministic: bool = True,
    ) -> tuple[Any, ShieldState]:
        """One step of the policy within and of the shield, with stable-baselines3's signature.

        Args:
            observation: What the policy within observes, and a reading for each sensor.
            state: What the last step returned; None starts an episode.
            episode_start: Rows ``(*B,)`` whose observation is the first of an episode.
            deterministic: For the policy within.

        Returns:
            The action ``(*B, size)``, and the state.

        Raises:
            ObservationError: If the observation has no keys, the state is none of a shield, or what
                is proposed is no action; also as for :meth:`aicon_torch.Policy.predict`.
            OptionError: If what the policy within returns is no action and state.
        """
        if not isinstance(observation, Mapping):
            raise ObservationError(
                f"expected an observation by key, with a reading for each sensor of the shield "
                f"({choices(self.model.sensors)}), got {type(observation).__name__}."
            )

        memory, inner = (None, None) if state is None else _checked(state)

        # The policy may change in place what it is given.
        seen = {
            key: _copied(reading) if key in self._keys else reading
            for key, reading in observation.items()
        }

        if hasattr(self.inner, "predict"):
            told = self.inner.predict(observation, inner, episode_start, deterministic)
            if not isinstance(told, tuple | list) or len(told) != 2:
                raise OptionError(
                    f"policy: its predict returned {told!r}; expected an action and a state."
                )
            proposal, inner = told
        else:
            proposal = self.inner(observation)

        seen[PROPOSAL] = _numbers(proposal, self.model.like)
        action, memory = self.policy.predict(seen, memory, episode_start)
        return action, ShieldState(memory, inner)

    def act(self, observation: Mapping[str, Any]) -> Any:
        """One step of a single episode, with the state kept here."""
        action, self._state = self.predict(observation, self._state)
        return action

    def reset(self) -> None:
        """Forget the state that :meth:`act` keeps; the policy within, too, if it can."""
        self._state = None
        getattr(self.inner, "reset", lambda: None)()

    def compile(self) -> "Shield":
        """The same shield with its step compiled: see :meth:`aicon_torch.Policy.compile`."""
        compiled = copy.copy(self)
        compiled.policy, compiled._state = self.policy.compile(), None
        return compiled

    def export(self, path: str | Path, target: str | None = None, **description: str) -> None:
        """Write the shield, without the policy within: see :meth:`aicon_torch.Policy.export`.

        It reads what is proposed under the key ``"proposal"``.
        """
        self.policy.export(path, target, **description)

    def trace(self, state: ShieldState) -> StepTrace:
        """What the step that returned this state knew and decided.

        Args:
            state: The state.

        Raises:
            ObservationError: If it is no state of a shield.
        """
        return self.policy.trace(_checked(state).memory)

    def explain(self, state: ShieldState, row: int | tuple[int, ...] = ()) -> Shielding:
        """What the step that returned this state made of the proposal, and why.

        Args:
            state: The state.
            row: Which row of the batch.

        Raises:
            ObservationError: If it is no state of a shield.
            ValueError: If the row names no single one of the batch.
        """
        return shielding(self.policy.model, NOMINAL, _checked(state).memory, row)


def _following(
    model: WorldModel,
    nominal: Callable[..., Tensor] | None,
    size: int | None,
    goes_around: bool,
) -> WorldModel:
    """The model with the goal to do what is proposed."""
    if not isinstance(model, WorldModel):
        raise OptionError(
            f"model: expected a WorldModel, such as policy.model, got {type(model).__name__}."
        )
    for sensor_name, sensor in model.sensors.items():
        if PROPOSAL in (sensor_name, sensor.key):
            raise GraphError(
                f"model: the sensor {sensor_name!r} has the name or the key {PROPOSAL!r}, under "
                "which a shield reads what is proposed."
            )
    if len(model.actuators) != 1:
        raise GraphError(
            f"model: it has the actuators {choices(model.actuators)}; a shield drives exactly one."
        )
    safety_goals = [goal for goal in model.goals.values() if goal.safety]
    if not safety_goals:
        raise GraphError(
            f"model: none of its goals ({choices(model.goals)}) is a safety goal, so there is "
            "nothing to keep: Goal(..., safety=True)."
        )

    if nominal is not None and not callable(nominal):
        raise OptionError(
            f"nominal={nominal!r}: expected a function of {PROPOSAL!r} and any quantities, or None."
        )

    ((name, actuator),) = model.actuators.items()
    escape = WayAround() if goes_around else None
    dampers = replace(actuator.dampers, escape=escape, haste=1.0)  # no faster than is proposed

    # The proposal is read, what it means is estimated, and to do that is the goal.
    proposal = Sensor(actuator.size if size is None else size, actuator.unit)
    asked = _Asked(NOMINAL, _as_it_is if nominal is None else nominal)
    if PROPOSAL not in asked.inputs:
        raise GraphError(
            f"nominal: it reads {choices(asked.inputs)}; expected {PROPOSAL!r} among them, which "
            "is what the policy proposes."
        )
    follow = Goal("follow", Interconnection(_disagreement, inputs=[name, NOMINAL]))
    following = WorldModel(
        sensors={**model.sensors, PROPOSAL: proposal},
        actuators={name: replace(actuator, dampers=dampers)},
        estimators=[*model.declaration.estimators, asked],
        goals=[*safety_goals, follow],
        dt=model.dt,
        clock=model.clock,
        dtype=model.like.dtype,
    )

    # An action of one component would count for all of them.
    shape = following.quantities[NOMINAL].shape
    if shape != (actuator.size,):
        raise GraphError(
            f"What is proposed means an action of shape {shape}; expected {(actuator.size,)}, as "
            f"the actuator {name!r} has it: see nominal= and size=."
        )
    return following


class _Asked(Deterministic):
    """The action that is asked for: what a proposal means, and rest where there is none."""

    def forward(self, values: Values, output: str) -> Tensor:
        """The action ``(*B, size)``; a sensor without a reading repeats its last one."""
        meant = super().forward(values, output)
        flag = PROPOSAL + PRESENT
        if flag not in values:
            return meant
        return torch.where(values[flag].unsqueeze(-1), meant, 0.0)


def _as_it_is(proposal: Tensor) -> Tensor:
    """The proposal is an action, ``(*B, size)``."""
    return proposal


def _disagreement(action: Tensor, nominal: Tensor) -> Tensor:
    """The cost g = −a·w ``(*B,)``, whose gradient is −w wherever the action is."""
    return -(action * stop(nominal)).sum(-1)  # stops: moving is not to change what is asked for


def _keys_of(model: WorldModel) -> frozenset[str]:
    """The keys of an observation that a model reads: readings, their ages, executed actions."""
    keys = {sensor.key_of(name) for name, sensor in model.sensors.items()}
    keys |= {sensor.age_key for sensor in model.sensors.values() if sensor.age_key is not None}
    keys |= {actuator.key for actuator in model.actuators.values() if actuator.key is not None}
    return frozenset(keys)


def _copied(reading: Any) -> Any:
    """A reading that nobody else can change."""
    if isinstance(reading, Tensor):
        return reading.detach().clone()  # a reading is a constant of the step
    return copy.deepcopy(reading) if isinstance(reading, np.ndarray | list) else reading


def _numbers(proposal: Any, like: Tensor) -> Any:
    """The proposal as numbers ``(*B, size)``, a tensor if it is one; NaN where a mask is."""
    called, unit = "what the policy within proposes", "the unit of a proposal"
    if isinstance(proposal, Tensor):
        return as_tensor(called, unit, proposal, like)
    return as_array(called, unit, proposal)


def _checked(state: Any) -> ShieldState:
    """A state, if it is one of a shield.

    Raises:
        ObservationError: If it is none.
    """
    if not isinstance(state, ShieldState):
        raise ObservationError(
            f"state: expected the ShieldState that the last step returned (action, state = "
            f"shield.predict(observation, state)), got {type(state).__name__}."
        )
    return state
