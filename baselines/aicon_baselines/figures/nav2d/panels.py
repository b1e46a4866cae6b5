"""The six moments that the figure shows, and its numbers."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.figures.nav2d.recording import Recording
from aicon_baselines.figures.pictures import Panel, in_order
from aicon_envs.nav2d import shortest_path_length


def choose_panels(recording: Recording) -> list[Panel]:
    """Six moments, in order of time.

    (a) The uncertainty's path is the strongest for the last time; (b) the longest exploration begins; (c)-(e) from
    there to the end of the last exploration, a quarter of the way apart, one of them moved to the sharpest turn; (f)
    the end. Without exploration (b)-(e) are a fifth of the way apart.

    Raises:
        ComparisonError: If the rollout is too short for six panels.
    """
    last = recording.steps - 1
    if last < 6:
        raise ComparisonError(f"the rollout has {recording.steps} steps; six panels need 7 or more")
    if recording.spans:
        begin, _ = max(recording.spans, key=lambda span: span[1] - span[0])
        end = recording.spans[-1][1]
        marks = [begin, *_along(recording, begin, end, (0.25, 0.5, 0.75))]
        corner = _sharpest_turn(recording, begin, end)
        turned = min((1, 2, 3), key=lambda index: abs(recording.travelled[marks[index]] - recording.travelled[corner]))
        marks[turned] = corner
        titles = ["Conflict: the wall is in the way", *["Exploring along the wall"] * 3]
        titles[turned] = "Rounding a corner"
    else:
        marks = _along(recording, 0, last, (0.2, 0.4, 0.6, 0.8))
        titles = ["On the way"] * 4
    triangulating = _end_of_triangulation(recording, marks[0])
    endings = {"arrival": "PartialPath at the target", "collision": "Collision", "time limit": "Out of time"}
    steps = in_order([triangulating, *marks, last], last)
    titles = ["Triangulating: sideways first", *titles, endings[recording.ending]]
    return [Panel(*panel) for panel in zip("abcdef", steps, titles, strict=True)]


def _along(recording: Recording, begin: int, end: int, shares: Sequence[float]) -> list[int]:
    """The steps at shares of the way from one step to another."""
    way = recording.travelled
    return [int(np.searchsorted(way, way[begin] + share * (way[end] - way[begin]))) for share in shares]


def _sharpest_turn(recording: Recording, begin: int, end: int, reach: float = 0.7) -> int:
    """The step between two others where the way bends most, seen from `reach` m before to `reach` m after."""
    way, positions = recording.travelled, recording.positions
    inner = np.arange(begin, end)[(way[begin:end] > way[begin] + reach) & (way[begin:end] < way[end] - reach)]
    if not len(inner):
        return (begin + end) // 2
    behind = positions[inner] - positions[np.searchsorted(way, way[inner] - reach)]
    ahead = positions[np.minimum(np.searchsorted(way, way[inner] + reach), len(way) - 1)] - positions[inner]
    straight = (behind * ahead).sum(axis=1) / (np.linalg.norm(behind, axis=1) * np.linalg.norm(ahead, axis=1))
    return int(inner[np.argmin(straight)])


def _end_of_triangulation(recording: Recording, before: int) -> int:
    """The last step, in the first half before another, at which p₂ is the strongest, or else has its largest share."""
    early = slice(1, max(2, before // 2))
    stack = np.stack([recording.strengths[name][early] for name in ("p2", "p1", "p3")])
    strongest = np.flatnonzero(stack.argmax(axis=0) == 0)
    return 1 + int(strongest[-1] if len(strongest) else np.argmax(stack[0] / stack.sum(axis=0)))


def summary(recording: Recording, panels: Sequence[Panel]) -> dict[str, Any]:
    """The numbers of the figure."""
    dt = recording.policy.model.dt
    world = recording.world
    return {
        "map": recording.name,
        "seed": recording.seed,
        "ending": recording.ending,
        "steps": recording.steps,
        "duration_s": round(recording.steps * dt, 3),
        "path_length_m": round(float(recording.travelled[-1]), 3),
        "shortest_path_m": round(shortest_path_length(world.obstacles, world.start, world.target, recording.radius), 3),
        "panels": [
            {"panel": panel.letter, "time_s": round(panel.step * dt, 3), "title": panel.title} for panel in panels
        ],
        "explorations_s": [[round(first * dt, 3), round(last * dt, 3)] for first, last in recording.spans],
        "trace_sigma_m2": {
            f"{seconds} s": float(recording.uncertainty[step])
            for seconds in (0, 1, 5)
            if (step := round(seconds / dt)) < recording.steps
        },
    }
