"""Conflicts that do not end, and constraints that hold the robot up."""

from collections import Counter
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from aicon_baselines.diagnosis.finding import Finding, listed, percent, times
from aicon_baselines.diagnosis.history import History, MeetingCurve
from aicon_baselines.evaluation.recording import true_intervals

OPPOSED = -0.6
"""Cosine below which gradients oppose each other, as in :class:`aicon_torch.Exploration`."""

OFTEN = 0.2
"""Share of the time from which on something is worth telling."""


def find_conflicts(history: History, since: int) -> Iterator[Finding]:
    """Where gradients opposed each other, explored or not, from a step on.

    Args:
        history: The episode.
        since: The step.
    """
    for name, whole in history.meetings.items():
        meeting = whole.since(since)
        compared = meeting.opponent >= 0
        opposed = (meeting.cosine < OPPOSED) & compared

        if meeting.exploring.mean() >= OFTEN:
            steps, in_words = meeting.exploring & compared, _explored
        elif opposed.mean() >= 0.5:
            steps, in_words = opposed, _not_explored
        else:
            continue

        if steps.any():
            text, goals = in_words(name, meeting, steps)
            yield Finding("conflict", text, since * history.dt, goals)


def find_constraints(history: History, since: int) -> Iterator[Finding]:
    """Whether safety goals held an actuator up, from a step on."""
    for name, curve in history.actuators.items():
        escaping = curve.escaping[since:]
        if escaping.mean() < OFTEN:
            continue

        near = _near_goals(history, since)
        held = f" What is near its bound: {listed(near)}." if near else ""
        text = (
            f"Safety goals hold {name} up: for {percent(escaping.mean())} of the time it gave up "
            "descending to get away from where they brought it to rest, "
            f"{times(len(true_intervals(escaping)))}.{held}"
        )
        yield Finding("constraint", text, since * history.dt, tuple(history.gaps))


def _explored(
    name: str, meeting: MeetingCurve, steps: NDArray[np.bool_]
) -> tuple[str, tuple[str, ...]]:
    """A conflict that was explored in some steps, in words, and its goals."""
    exploring = meeting.exploring
    dominant, opponent, share, cosine = _most_frequent(meeting, steps)
    began = times(len(true_intervals(exploring)))
    still = "and was not over at the end" if exploring[-1] else "and paused at the end"
    text = (
        f"A conflict at {name} does not end: it is explored for {percent(exploring.mean())} of "
        f"the time, began {began}, {still}. For {percent(share)} of that, it "
        f"was {meeting.labels[dominant]} against {meeting.labels[opponent]} (cosine {cosine:+.2f})."
    )
    return text, _goals(meeting, dominant, opponent)


def _not_explored(
    name: str, meeting: MeetingCurve, steps: NDArray[np.bool_]
) -> tuple[str, tuple[str, ...]]:
    """A conflict in some steps in which one gradient was too strong to be explored."""
    dominant, opponent, _, cosine = _most_frequent(meeting, steps)
    magnitudes = meeting.magnitudes[steps]
    ratio = np.median(magnitudes[:, dominant] / np.maximum(magnitudes[:, opponent], 1e-300))
    strength = "Both are about equally strong, and nothing is explored."
    if ratio > 1.5:
        strength = f"The first is {ratio:.2g} times as strong, so that it hardly ever explores."
    text = (
        f"Gradients oppose each other at {name} for {percent(steps.mean())} of the time (cosine "
        f"{cosine:+.2f}): {meeting.labels[dominant]} against {meeting.labels[opponent]}. "
        f"{strength}"
    )
    return text, _goals(meeting, dominant, opponent)


def _most_frequent(
    meeting: MeetingCurve, steps: NDArray[np.bool_]
) -> tuple[int, int, float, float]:
    """The dominant and opponent of most of these steps, their share of them, and their cosine."""
    dominants, opponents = meeting.dominant[steps], meeting.opponent[steps]
    pairs = Counter(zip(dominants.tolist(), opponents.tolist(), strict=True))

    (dominant, opponent), count = pairs.most_common(1)[0]
    theirs = (dominants == dominant) & (opponents == opponent)
    cosine = float(np.median(meeting.cosine[steps][theirs]))
    return dominant, opponent, count / int(steps.sum()), cosine


def _goals(meeting: MeetingCurve, dominant: int, opponent: int) -> tuple[str, ...]:
    return tuple(dict.fromkeys((meeting.goals[dominant], meeting.goals[opponent])))


def _near_goals(history: History, since: int) -> list[str]:
    """Safety goals whose gap was almost used up, with how often."""
    near: list[str] = []
    for name, gap in history.gaps.items():
        share = (gap[since:] < 0.1 * np.median(gap)).mean()
        if share >= OFTEN:
            near.append(f"{name} ({percent(share)} of the time, least gap {gap.min():.3g})")
    return near
