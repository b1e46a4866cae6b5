"""Explanations: what one control step decided, in numbers."""

from dataclasses import dataclass

import torch

from aicon_torch.control.backward import BackwardPass
from aicon_torch.resolution import Memory


@dataclass(frozen=True)
class Candidate:
    """One gradient that arrived: its trace from the goal on, its magnitude and its rank (0 leads, None unused)."""

    trace: str
    strength: float
    rank: int | None


@dataclass(frozen=True)
class MeetingReport:
    """What happened at a quantity where gradients met, or at an actuator that one reached.

    Attributes:
        candidates: The gradients, in the order of the graph.
        cosine: Cosine between the leader and the gradient it was compared with, the second strongest or the strongest
            that opposes it (1 if none does); None where a single one arrived.
        exploring: Whether the quantity moved in a nullspace instead of downhill.
    """

    candidates: tuple[Candidate, ...]
    cosine: float | None
    exploring: bool


@dataclass(frozen=True)
class GoalReport:
    """A goal's cost now, and by how much the action changes it in the next step, to first order: ∇ₐg · a."""

    cost: float
    predicted_change: float


@dataclass(frozen=True)
class Explanation:
    """What one control step decided.

    Attributes:
        action: The action by actuator.
        goals: Cost and predicted change by goal.
        meetings: What happened, by quantity.
    """

    action: dict[str, tuple[float, ...]]
    goals: dict[str, GoalReport]
    meetings: dict[str, MeetingReport]

    def __str__(self) -> str:
        """A few lines to read."""
        lines = [f"{name} = ({', '.join(f'{x:+.3f}' for x in value)})" for name, value in self.action.items()]
        for name, goal in self.goals.items():
            lines.append(f"goal {name}: cost {goal.cost:.4g}, predicted change {goal.predicted_change:+.2g}")
        for name, meeting in self.meetings.items():
            state = "exploring" if meeting.exploring else "descending"
            cosine = "" if meeting.cosine is None else f", cosine to its rival {meeting.cosine:+.2f}"
            lines.append(f"at {name}: {state}{cosine}")
            for candidate in meeting.candidates:
                rank = "-" if candidate.rank is None else candidate.rank
                lines.append(f"  rank {rank}: {candidate.trace}, strength {candidate.strength:.3g}")
        return "\n".join(lines)


def explain(sweep: BackwardPass, memory: Memory, row: int | tuple[int, ...] = ()) -> Explanation:
    """Read off a memory what the step that returned it decided.

    Args:
        sweep: The sweep of the policy.
        memory: The memory, ``(*B, …)``.
        row: Which row of the batch.
    """
    model = sweep.model
    one = {key: value[row] for key, value in memory.items()}
    if one[next(iter(model.actuators))].dim() != 1:
        batch = tuple(memory[next(iter(model.actuators))].shape[:-1])
        raise ValueError(f"row={row!r}: the memory has batch shape {batch}; name one row of it.")
    actions = {name: one[name].detach().requires_grad_() for name in model.actuators}
    with torch.enable_grad():
        costs = model.uncut(one, actions)
    goals: dict[str, GoalReport] = {}
    for name, cost in costs.items():
        slopes = torch.autograd.grad(cost, list(actions.values()), retain_graph=True, allow_unused=True)
        moves = zip(slopes, actions.values(), strict=True)
        change = sum(float((slope * action.detach()).sum()) for slope, action in moves if slope is not None)
        goals[name] = GoalReport(float(cost.detach()), change)
    places = [name for name in sweep.arrivals if sweep.meets(name) or name in model.actuators]
    meetings = {name: _report(sweep, one, name) for name in places}
    return Explanation({name: tuple(one[name].tolist()) for name in actions}, goals, meetings)


def _report(sweep: BackwardPass, one: Memory, name: str) -> MeetingReport:
    arrivals = [f"{arrival} → {name}" for arrival in sweep.arrivals[name]]
    if not sweep.meets(name):
        strength = float(torch.linalg.vector_norm(one[f"{name}/gradient"]))
        return MeetingReport((Candidate(arrivals[0], strength, 0),), None, False)
    gradients = one[f"{name}/gradients"]
    norms = torch.linalg.vector_norm(gradients, dim=-1)
    held = one[f"{name}/rank"].tolist() if f"{name}/rank" in one else []
    candidates = tuple(
        Candidate(arrival, float(norm), held.index(index) if index in held else None)
        for index, (arrival, norm) in enumerate(zip(arrivals, norms, strict=True))
    )
    if f"{name}/cosine" in one:
        return MeetingReport(candidates, float(one[f"{name}/cosine"]), bool(one[f"{name}/exploring"]))
    first, second = gradients[norms.topk(2).indices]
    return MeetingReport(candidates, float(torch.nn.functional.cosine_similarity(first, second, dim=0)), False)
