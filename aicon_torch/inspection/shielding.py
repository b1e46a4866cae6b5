"""What a shield made of a proposal, and why, in numbers to read."""

from dataclasses import dataclass

import torch

from aicon_torch.graph import WorldModel
from aicon_torch.inspection.rows import of_one_robot
from aicon_torch.resolution import Memory
from aicon_torch.safety.bounds import safety_of


@dataclass(frozen=True)
class Held:
    """A safety goal that does not allow what is proposed.

    Attributes:
        gap: The gap that allows the least of it, in the goal's unit.
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
    """

    proposal: tuple[float, ...]
    action: tuple[float, ...]
    held: dict[str, Held]
    is_around: bool

    def __str__(self) -> str:
        """A few lines to read."""
        lines = [f"proposed {_numbers(self.proposal)}, done {_numbers(self.action)}"]
        for name, held in self.held.items():
            speeds = f"would change by {held.asked:+.3g}/s, may by {held.allowed:+.3g}/s"
            lines.append(f"  {name}: a gap of {held.gap:.3g} {speeds}")
        if self.is_around:
            lines.append("  held up: on the way around")
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
        held=_held(model, name, values, asked),
        is_around=around is not None and bool(around),
    )


def _held(model: WorldModel, name: str, values: Memory, asked: torch.Tensor) -> dict[str, Held]:
    """The safety goals that do not allow an action ``(size,)``, each with its worst gap."""
    safety = safety_of(model)[name]
    found: dict[str, Held] = {}
    for goal in safety.goals:
        # The rate of each gap that is asked for, ∇d · a, and the least that is allowed.
        slopes, bounds, gaps = safety.rows_of(goal, values)
        speed = (slopes * asked).sum(-1)
        worst = int((speed - bounds).argmin())
        if speed[worst] < bounds[worst] - 1e-6:
            found[goal.name] = Held(
                gap=float(gaps[worst]), asked=float(speed[worst]), allowed=float(bounds[worst])
            )
    return found


def _numbers(action: tuple[float, ...]) -> str:
    return "(" + ", ".join(f"{component:+.3f}" for component in action) + ")"
