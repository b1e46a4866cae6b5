"""The six moments that the figure shows, and its numbers."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.figures.nav2d.recording import NavigationRecording
from aicon_baselines.figures.panels import LABELS, Panel, increasing
from aicon_baselines.figures.summary import episode_numbers, panel_numbers
from aicon_envs.nav2d import shortest_path_length

_ENDINGS = {
    "arrival": "Arrival at the target",
    "collision": "Collision",
    "time limit": "Out of time",
}
_REACH = 0.7  # m before and after a turn, from which it is seen


def choose_panels(recording: NavigationRecording) -> list[Panel]:
    """Six moments, in order of time.

    (a) The uncertainty's path is the strongest for the last time; (b) the longest exploration
    begins; (c)-(e) from there to the end of the last exploration, a quarter of the distance apart,
    one of them moved to the sharpest turn; (f) the end. Without exploration (b)-(e) are a fifth of
    the distance apart.

    Raises:
        ComparisonError: If the rollout is too short for six panels.
    """
    last = recording.steps - 1
    if last < len(LABELS):
        raise ComparisonError(f"the rollout has {recording.steps} steps; six panels need 7 or more")

    # (b)-(e): how it gets past what is in the way.
    if recording.explorations:
        middle, middle_titles = _explorations(recording)
    else:
        middle = _steps_along(recording, 0, last, (0.2, 0.4, 0.6, 0.8))
        middle_titles = ["On the way"] * len(middle)

    # (a) comes before them, and (f) after.
    first = _end_of_triangulation(recording, middle[0])
    steps = increasing([first, *middle, last], last)
    titles = ["Triangulating: sideways first", *middle_titles, _ENDINGS[recording.ending]]

    return [Panel(*panel) for panel in zip(LABELS, steps, titles, strict=True)]


def _explorations(recording: NavigationRecording) -> tuple[list[int], list[str]]:
    """Steps and titles of the panels (b)-(e) of a rollout that explores."""
    begin, _ = max(recording.explorations, key=_duration)
    _, end = recording.explorations[-1]

    steps = [begin, *_steps_along(recording, begin, end, (0.25, 0.5, 0.75))]
    titles = ["Conflict: the wall is in the way", *["Exploring along the wall"] * 3]

    # Of (c)-(e), the one that is nearest to the sharpest turn shows it.
    corner = _sharpest_turn(recording, begin, end)
    distances = np.abs(recording.travelled[steps[1:]] - recording.travelled[corner])
    nearest = 1 + int(distances.argmin())
    steps[nearest], titles[nearest] = corner, "Rounding a corner"

    return steps, titles


def _duration(interval: tuple[int, int]) -> int:
    begin, end = interval
    return end - begin


def _steps_along(
    recording: NavigationRecording, begin: int, end: int, shares: Sequence[float]
) -> list[int]:
    """The steps at shares of the distance travelled from one step to another."""
    travelled = recording.travelled
    goals = travelled[begin] + np.array(shares) * (travelled[end] - travelled[begin])
    steps: list[int] = np.searchsorted(travelled, goals).tolist()
    return steps


def _sharpest_turn(recording: NavigationRecording, begin: int, end: int) -> int:
    """The step between two others at which the trajectory bends most."""
    travelled, positions = recording.travelled, recording.positions

    # Only steps from which the trajectory reaches far enough in both directions.
    between = travelled[begin:end]
    inner = (between > travelled[begin] + _REACH) & (between < travelled[end] - _REACH)
    steps = np.arange(begin, end)[inner]
    if not len(steps):
        return (begin + end) // 2

    # Where it comes from, and where it goes to, as seen from each step.
    before = np.searchsorted(travelled, travelled[steps] - _REACH)
    after = np.searchsorted(travelled, travelled[steps] + _REACH)
    behind = positions[steps] - positions[before]
    ahead = positions[np.minimum(after, len(travelled) - 1)] - positions[steps]

    # The sharper the turn, the smaller the cosine.
    lengths = np.linalg.norm(behind, axis=1) * np.linalg.norm(ahead, axis=1)
    cosines = (behind * ahead).sum(axis=1) / lengths
    return int(steps[cosines.argmin()])


def _end_of_triangulation(recording: NavigationRecording, before: int) -> int:
    """The last step, in the first half before another, at which p₂ is the strongest path.

    Where it never is, the step at which it has the largest share of all strengths.
    """
    early = slice(1, max(2, before // 2))
    strengths = np.stack([recording.strengths[name][early] for name in ("p2", "p1", "p3")])

    leads = np.flatnonzero(strengths.argmax(axis=0) == 0)
    if len(leads):
        return 1 + int(leads[-1])

    shares = strengths[0] / strengths.sum(axis=0)
    return 1 + int(shares.argmax())


def summarize(recording: NavigationRecording, panels: Sequence[Panel]) -> dict[str, Any]:
    """The numbers of the figure."""
    world = recording.world
    shortest = shortest_path_length(world.obstacles, world.start, world.target, recording.radius)

    uncertainty: dict[str, float] = {}
    for seconds in (0, 1, 5):
        step = round(seconds / recording.time_step)
        if step < recording.steps:
            uncertainty[f"{seconds} s"] = float(recording.uncertainty[step])

    return {
        "map": recording.world.name,
        **episode_numbers(recording),
        "path_length_m": round(float(recording.travelled[-1]), 3),
        "shortest_path_m": round(shortest, 3),
        **panel_numbers(recording, panels),
        "trace_sigma_m2": uncertainty,
    }
