"""Explanations: what one control step decided, in numbers to read."""

from collections.abc import Iterator
from dataclasses import dataclass

import torch
from torch import Tensor

from aicon_torch.control.backward import BackwardPass
from aicon_torch.graph import WorldModel
from aicon_torch.inspection.rows import of_one_robot
from aicon_torch.inspection.trace import UNUSED, QuantityTrace, trace
from aicon_torch.quantities import AGE, FROZEN, PRESENT, SILENCE, Sensor
from aicon_torch.readings.sensor_validation import NEVER, REFUSED
from aicon_torch.readings.validation import BEGINS
from aicon_torch.resolution import Memory
from aicon_torch.safety.watchdog import confidence


@dataclass(frozen=True)
class Candidate:
    """One gradient that arrived: its path, magnitude and rank (0 dominates, None is unused)."""

    path: str
    magnitude: float
    rank: int | None


@dataclass(frozen=True)
class QuantityReport:
    """What happened at a quantity where gradients met, or at an actuator that one reached.

    Attributes:
        candidates: The gradients, in the order of the graph.
        cosine: Cosine between the dominant gradient and the one it was compared with, the second
            strongest or the strongest that opposes it (1 if none does); None where a single one
            arrived.
        exploring: Whether the quantity moved in a nullspace instead of downhill.
    """

    candidates: tuple[Candidate, ...]
    cosine: float | None
    exploring: bool


@dataclass(frozen=True)
class GoalReport:
    """A goal's cost, and by how much the action changes it in a step, to first order: ∇ₐg · a."""

    cost: float
    predicted_change: float


@dataclass(frozen=True)
class Explanation:
    """What one control step decided.

    Attributes:
        action: The action by actuator.
        goals: Cost and predicted change by goal.
        quantities: What happened, by quantity.
        alerts: Sentences on sensors without a reading, and on what that does to the action.
    """

    action: dict[str, tuple[float, ...]]
    goals: dict[str, GoalReport]
    quantities: dict[str, QuantityReport]
    alerts: tuple[str, ...] = ()

    def __str__(self) -> str:
        """A few lines to read."""
        lines: list[str] = []
        for name, action in self.action.items():
            lines.append(f"{name} = {as_text(action)}")
        for name, goal in self.goals.items():
            change = f"predicted change {goal.predicted_change:+.2g}"
            lines.append(f"goal {name}: cost {goal.cost:.4g}, {change}")
        for name, quantity in self.quantities.items():
            lines += _in_words(name, quantity)
        lines += self.alerts
        return "\n".join(lines)


def explain(backward: BackwardPass, memory: Memory, row: int | tuple[int, ...] = ()) -> Explanation:
    """Read off a memory what the step that returned it decided.

    Args:
        backward: The backward pass of the policy.
        memory: The memory, ``(*B, …)``.
        row: Which row of the batch.

    Raises:
        ValueError: If it names no single row of it.
    """
    model = backward.model

    one_robot = of_one_robot(memory, next(iter(model.actuators)), row)
    step = trace(backward, one_robot)
    actions = {name: step.values[name] for name in model.actuators}
    return Explanation(
        action={name: tuple(action.tolist()) for name, action in actions.items()},
        goals=_goal_reports(backward, one_robot, actions),
        quantities={name: _report(quantity) for name, quantity in step.quantities.items()},
        alerts=tuple(alerts(model, one_robot)),
    )


def alerts(model: WorldModel, memory: Memory) -> Iterator[str]:
    """Which sensors of one robot have no reading, why, and what the action does."""
    share = float(confidence(model.sensors, memory))
    for name, sensor in model.sensors.items():
        if bool(memory[name + PRESENT]) or name == model.clock:
            continue

        yield f"no reading of {sensor.key_of(name)!r}: {_since_when(name, sensor, memory)}"

        # What that does.
        age = float(memory[name + AGE])
        if sensor.max_age is not None and age > sensor.max_age:
            yield f"  older than {sensor.max_age:.2f} s: {share:.0%} of the action is executed"
        elif sensor.max_gap is not None and float(memory[name + SILENCE]) > sensor.max_gap:
            yield f"  none in {sensor.max_gap:.2f} s: {share:.0%} of the action is executed"

    for name in model.actuators:
        if bool(memory.get(f"{name}/escape/gave_up", False)):
            nearest = float(memory[f"{name}/escape/nearest"])
            yield f"{name} has given up: wherever it went, the goals cost {nearest:.4g} or more"

    if bool(memory[BEGINS]):
        yield "at rest: the episode begins with the first reading of each sensor"
        for name in model.declaration.commands:
            yield f"  until then send {name!r} no command: it may be made of what was never read"


def as_text(action: tuple[float, ...]) -> str:
    """``(+0.100, -0.200)``."""
    return "(" + ", ".join(f"{component:+.3f}" for component in action) + ")"


def _since_when(name: str, sensor: Sensor, memory: Memory) -> str:
    """How old the last reading of a sensor of one robot is, and why none came after it."""
    age = float(memory[name + AGE])
    if age >= NEVER:
        demands: list[str] = []
        if sensor.range is not None:
            demands.append(f"within range={sensor.range}")
        if sensor.is_possible is not None:
            demands.append("that is_possible allows")
        return " ".join(("none ever", *demands))

    since = f"the last is {age:.2f} s old"
    if sensor.rate_limit is not None and int(memory[name + REFUSED]) > 0:
        since += f", and what came since was refused, beyond rate_limit={sensor.rate_limit:g}"
    if sensor.driven_by is not None and bool(memory[name + FROZEN]):
        since += ", and it repeats itself"
    return since


def _goal_reports(
    backward: BackwardPass, values: Memory, actions: dict[str, Tensor]
) -> dict[str, GoalReport]:
    """Each goal's cost, and the product of its gradient with the action."""
    # The whole graph as one function of the actions, nothing cut.
    leaves = {name: action.detach().requires_grad_() for name, action in actions.items()}
    with torch.enable_grad():
        costs = backward.model.end_to_end_costs({**backward.model.values(values), **values}, leaves)

    # To first order, an action a changes the goal g by ∇ₐg · a.
    reports: dict[str, GoalReport] = {}
    for goal, cost in costs.items():
        gradients = torch.autograd.grad(
            cost, list(leaves.values()), retain_graph=True, allow_unused=True
        )
        change = 0.0
        for gradient, action in zip(gradients, actions.values(), strict=True):
            if gradient is not None:
                change += float((gradient * action).sum())
        reports[goal] = GoalReport(float(cost.detach()), change)
    return reports


def _report(quantity: QuantityTrace) -> QuantityReport:
    """A trace without batch as numbers."""
    candidates: list[Candidate] = []
    columns = zip(
        quantity.labels, quantity.magnitudes.tolist(), quantity.ranks.tolist(), strict=True
    )
    for label, magnitude, rank in columns:
        candidates.append(Candidate(label, magnitude, None if rank == UNUSED else rank))

    cosine = float(quantity.cosine) if len(candidates) > 1 else None
    return QuantityReport(tuple(candidates), cosine, bool(quantity.exploring))


def _in_words(name: str, quantity: QuantityReport) -> list[str]:
    """Lines on one quantity."""
    state = "exploring" if quantity.exploring else "descending"
    if quantity.cosine is not None:
        state += f", cosine to its opponent {quantity.cosine:+.2f}"

    lines = [f"at {name}: {state}"]
    for candidate in quantity.candidates:
        rank = "-" if candidate.rank is None else candidate.rank
        lines.append(f"  rank {rank}: {candidate.path}, magnitude {candidate.magnitude:.3g}")
    return lines
