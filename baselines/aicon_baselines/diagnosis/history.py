"""What is looked at to find out why an episode failed: its memories, as curves over time."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from aicon_baselines.diagnosis.innovations import Innovations, innovations
from aicon_baselines.evaluation.recording import BoolArray, FloatArray, Recording, to_array
from aicon_torch import EKF, Actuator, Foresight, Policy, StepTrace, WorldModel
from aicon_torch.control.memory import GOAL_FACTORS
from aicon_torch.quantities import PRESENT

IntArray = NDArray[np.int64]


@dataclass(frozen=True)
class MeetingCurve:
    """What happened where gradients met, over the n steps of an episode.

    Attributes:
        labels: For each of g gradients its path, such as "reach → p_tar → x_rob".
        goals: For each gradient its goals, joined by "+".
        magnitudes: (n, g).
        dominant: Index of the leading gradient, (n,).
        opponent: Index of the gradient that it was compared with, (n,); −1 for none.
        cosine: Between the two, (n,).
        exploring: (n,).
    """

    labels: tuple[str, ...]
    goals: tuple[str, ...]
    magnitudes: FloatArray
    dominant: IntArray
    opponent: IntArray
    cosine: FloatArray
    exploring: BoolArray

    def since(self, step: int) -> "MeetingCurve":
        """The same from a step on."""
        curves = {
            name: values[step:]
            for name, values in vars(self).items()
            if name not in ("labels", "goals")
        }
        return MeetingCurve(self.labels, self.goals, **curves)


@dataclass(frozen=True)
class ActuatorCurve:
    """An actuator over the n steps of an episode.

    Attributes:
        share: Its action as a share of its limit, (n, 1) where the norm is limited and (n, size)
            where each component is; zero where there is no limit.
        gradient: Norm of the gradient that arrived, (n,).
        escaping: Whether it moved along the force of its constraints, (n,).
        smallest: Share of the limit by which the last inner step of its descent changed it; None
            where the action law does not iterate.
        constraints: Names of what limits it further.
        leads: The path from a goal whose gradient it followed, such as "reach → p_tar → a", (n,).
    """

    share: FloatArray
    gradient: FloatArray
    escaping: BoolArray
    smallest: float | None = None
    constraints: tuple[str, ...] = ()
    leads: tuple[str, ...] = ()


@dataclass(frozen=True)
class History:
    """An episode of n steps, as curves; what an episode did not have is empty.

    Attributes:
        dt: Time of a step, s.
        state: What the robot and its world did, as the policy estimates it, (n, d).
        costs: Cost of each goal that is followed, as far as it is switched on, (n,).
        gaps: What is left of each safety goal until it costs something, likewise, (n,).
        meetings: Where gradients met, by quantity.
        actuators: The actuators, by name.
        innovations: By how much readings differed from what was estimated.
        present: Whether each sensor but the clock had a reading, (n,) each.
        success: Whether the episode succeeded; None where nobody knows.
    """

    dt: float
    state: FloatArray
    costs: Mapping[str, FloatArray] = field(default_factory=dict)
    gaps: Mapping[str, FloatArray] = field(default_factory=dict)
    meetings: Mapping[str, MeetingCurve] = field(default_factory=dict)
    actuators: Mapping[str, ActuatorCurve] = field(default_factory=dict)
    innovations: Sequence[Innovations] = ()
    present: Mapping[str, BoolArray] = field(default_factory=dict)
    success: bool | None = None

    @property
    def steps(self) -> int:
        """Number of steps n."""
        return len(self.state)

    @property
    def times(self) -> FloatArray:
        """When each step was, (n,), s."""
        return self.dt * np.arange(self.steps, dtype=np.float64)

    @classmethod
    @torch.no_grad()
    def of(cls, recording: Recording) -> "History":
        """The history of an episode of a single robot.

        Raises:
            ValueError: If there are fewer than two steps, or more than one robot.
        """
        steps = len(recording.memories)
        if steps < 2:
            raise ValueError(f"memories: expected those of two steps or more, got {steps}.")

        policy, memory, trace = recording.policy, recording.memory, recording.trace
        values, factors = policy.model.values(trace.values), memory[GOAL_FACTORS][-1].tolist()
        costs: dict[str, FloatArray] = {}
        gaps: dict[str, FloatArray] = {}
        for factor, (name, goal) in zip(factors, policy.model.goals.items(), strict=True):
            if factor != 0 and goal.safety:
                gaps[name] = to_array(goal.gaps(values).amin(-1))
            elif factor != 0:
                costs[name] = to_array(trace.costs[name])

        # Who has no clock took as long as usual, which is no silence.
        sensors = [name for name in policy.model.sensors if name != policy.model.clock]
        return cls(
            dt=recording.time_step,
            state=_state(policy.model, trace),
            costs=costs,
            gaps=gaps,
            meetings=_meeting_curves(trace),
            actuators=_actuator_curves(policy, trace),
            innovations=innovations(policy.model, memory),
            present={name: _flags(memory[name + PRESENT]) for name in sensors},
            success=recording.success,
        )


def _state(model: WorldModel, trace: StepTrace) -> FloatArray:
    """What Kalman filters estimate, or else what is read, side by side."""
    means = [one.mean for one in model.estimators if isinstance(one, EKF) and not one.is_motion]
    columns = [to_array(trace.values[name]) for name in means or model.sensors]
    return np.concatenate([column.reshape(len(column), -1) for column in columns], axis=1)


def _meeting_curves(trace: StepTrace) -> dict[str, MeetingCurve]:
    """Where more than one gradient arrived."""
    curves: dict[str, MeetingCurve] = {}
    for name, quantity in trace.quantities.items():
        if len(quantity.paths) > 1:
            curves[name] = MeetingCurve(
                labels=quantity.labels,
                goals=tuple("+".join(goals) for goals in quantity.goals),
                magnitudes=to_array(quantity.magnitudes),
                dominant=quantity.dominant.numpy(force=True),
                opponent=quantity.opponent.numpy(force=True),
                cosine=to_array(quantity.cosine),
                exploring=_flags(quantity.exploring),
            )
    return curves


def _actuator_curves(policy: Policy, trace: StepTrace) -> dict[str, ActuatorCurve]:
    # The last inner step of a descent with foresight, as a share of the limit.
    law = policy.law
    smallest = law.step / law.iterations if isinstance(law, Foresight) else None

    curves: dict[str, ActuatorCurve] = {}
    for name, actuator in policy.model.actuators.items():
        quantity = trace.quantities.get(name)
        share = _share_of_limit(actuator, to_array(trace.values[name]))
        nothing = np.zeros(len(share))
        leads = [trace.leading_path(name, (step,)) for step in range(len(share))]

        curves[name] = ActuatorCurve(
            share=share,
            gradient=nothing if quantity is None else to_array(quantity.magnitudes.amax(-1)),
            escaping=nothing.astype(bool) if quantity is None else _flags(quantity.exploring),
            smallest=smallest,
            constraints=tuple(_name_of(one) for one in actuator.constraints),
            leads=tuple(" → ".join(path) for path in leads),
        )
    return curves


def _share_of_limit(actuator: Actuator, action: FloatArray) -> FloatArray:
    """The action by its limit: its norm (n, 1), or each component (n, size)."""
    limit = np.atleast_1d(np.asarray(actuator.limit, dtype=np.float64))
    if len(limit) == 1:
        action = np.linalg.norm(action, axis=-1, keepdims=True)
    return np.abs(action) / limit


def _name_of(constraint: object) -> str:
    """The name of a function, or of an object's class."""
    return getattr(constraint, "__name__", type(constraint).__name__)


def _flags(tensor: Tensor) -> BoolArray:
    return tensor.numpy(force=True).astype(bool)
