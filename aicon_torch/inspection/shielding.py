"""What a shield made of a proposal, and why, in numbers to read."""

import math
from dataclasses import dataclass

import torch
from torch import Tensor

from aicon_torch.control.memory import GOAL_FACTORS
from aicon_torch.graph import WorldModel
from aicon_torch.inspection.explanation import alerts, as_text
from aicon_torch.inspection.rows import of_one_robot
from aicon_torch.resolution import Memory
from aicon_torch.safety.bounds import NEGLIGIBLE, safety_of


@dataclass(frozen=True)
class Held:
    """A safety goal that does not allow what is proposed.

    Attributes:
        gap: The gap that allows the least of it, in the goal's unit; where it is no number, this or
            one of the others is not finite, and nothing moves.
        asked: How fast that gap would change, per second.
        allowed: How fast it may close at most; above zero it has to grow.
    """

    gap: float
    asked: float
    allowed: float


@dataclass(frozen=True)
class Shielding:
    """What one step made of a proposal.

    Attributes:
        proposal: What was asked for, as an action within the actuator's limits.
        action: What is done.
        held: The safety goals that did not allow it, by name.
        is_around: Whether it is on a way around what holds it up.
        alerts: Sentences on sensors without a reading, the proposal's among them, and on what that
            does to the action.
    """

    proposal: tuple[float, ...]
    action: tuple[float, ...]
    held: dict[str, Held]
    is_around: bool
    alerts: tuple[str, ...] = ()

    def __str__(self) -> str:
        """A few lines to read."""
        lines = [f"proposed {as_text(self.proposal)}, done {as_text(self.action)}"]
        for name, held in self.held.items():
            if not math.isfinite(held.gap + held.asked + held.allowed):
                lines.append(f"  {name}: a gap or its slope is no number, so nothing moves")
                continue
            speeds = f"would change by {held.asked:+.3g}/s, may by {held.allowed:+.3g}/s"
            lines.append(f"  {name}: a gap of {held.gap:.3g} {speeds}")
        if self.is_around:
            lines.append("  held up: on the way around")
        lines += self.alerts
        return "\n".join(lines)


def shielding(
    model: WorldModel, nominal: str, memory: Memory, row: int | tuple[int, ...] = ()
) -> Shielding:
    """Read off a memory what the step that returned it made of the proposal.

    Args:
        model: The graph.
        nominal: The quantity that says what is proposed.
        memory: The memory, ``(*B, …)``.
        row: Which row of the batch.

    Raises:
        ValueError: If it names no single row of it.
    """
    # A shield has one actuator.
    (name,) = model.actuators
    one_robot = of_one_robot(memory, name, row)
    values = model.values(one_robot)
    asked = model.actuators[name].clip(values[nominal])
    around = one_robot.get(f"{name}/escape/escaping")
    return Shielding(
        proposal=tuple(asked.tolist()),
        action=tuple(values[name].tolist()),
        held=_held(model, name, values, asked, one_robot[GOAL_FACTORS]),
        is_around=around is not None and bool(around),
        alerts=tuple(alerts(model, one_robot)),
    )


def _held(
    model: WorldModel, name: str, values: Memory, asked: Tensor, factors: Tensor
) -> dict[str, Held]:
    """The safety goals that do not allow an action ``(size,)``, each with its worst gap."""
    safety = safety_of(model)[name]
    is_on = dict(zip(model.goals, (factors != 0).tolist(), strict=True))
    found: dict[str, Held] = {}
    for goal in safety.goals:
        if not is_on[goal.name]:
            continue

        # The rate of each gap that is asked for, ∇d · a, and the least that is allowed.
        slopes, bounds, gaps = safety.rows_of(goal, values)
        speed = (slopes * asked).sum(-1)

        # What no action can serve holds up none; what is no number holds up all.
        is_known = (gaps + bounds + slopes.sum(-1)).isfinite()
        spare = torch.where(safety.moves(slopes), speed - bounds, torch.inf)
        spare = torch.where(is_known, spare, -torch.inf)

        worst = int(spare.argmin())
        if spare[worst] < -NEGLIGIBLE:
            found[goal.name] = Held(
                gap=float(gaps[worst]), asked=float(speed[worst]), allowed=float(bounds[worst])
            )
    return found
