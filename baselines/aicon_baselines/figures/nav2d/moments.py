"""The six moments of an episode that the navigation figure shows."""

from collections.abc import Sequence

import numpy as np

from aicon_baselines.figures.nav2d.recording import NavigationRecording

_ENDINGS = {
    "arrival": "Arrival at the target",
    "collision": "Collision",
    "time limit": "Out of time",
}
_REACH = 0.7  # m before and after a turn, from which it is seen


def story(recording: NavigationRecording) -> tuple[list[int], list[str]]:
    """The steps of six moments, and their titles.

    (a) The uncertainty's path is the strongest for the last time; (b) the longest exploration
    begins; (c)-(e) from there to the end of the last exploration, a quarter of the distance apart,
    one of them moved to the sharpest turn; (f) the end. Without exploration (b)-(e) are a fifth of
    the distance apart.
    """
    last = recording.steps - 1
    if recording.explorations:
        middle, titles = _explorations(recording)
    else:
        middle = _steps_along(recording, 0, last, (0.2, 0.4, 0.6, 0.8))
        titles = ["On the way"] * len(middle)

    first = _end_of_triangulation(recording, before=middle[0])
    ending = _ENDINGS[recording.ending]
    return [first, *middle, last], ["Triangulating: sideways first", *titles, ending]


def _explorations(recording: NavigationRecording) -> tuple[list[int], list[str]]:
    """Steps and titles of the moments (b)-(e) of a rollout that explores."""
    begin, _ = max(recording.explorations, key=lambda interval: interval[1] - interval[0])
    _, end = recording.explorations[-1]

    steps = [begin, *_steps_along(recording, begin, end, (0.25, 0.5, 0.75))]
    titles = ["Conflict: the wall is in the way", *["Exploring along the wall"] * 3]

    # Of (c)-(e), the one that is nearest to the sharpest turn shows it.
    corner = _sharpest_turn(recording, begin, end)
    distances = np.abs(recording.travelled[steps[1:]] - recording.travelled[corner])
    nearest = 1 + int(distances.argmin())
    steps[nearest], titles[nearest] = corner, "Rounding a corner"

    return steps, titles


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
