"""The six moments that the figure shows, what happens in each moment, and the figure's numbers."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.figures.pictures import Panel, in_order, spans
from aicon_baselines.figures.pusht.recording import BoolArray, FloatArray, Recording
from aicon_envs.pusht.simulation import PUSHER_RADIUS

_CORNER = 1.0  # px from a corner within which a contact is at it
_NEAR = 10.0  # px between pusher and object within which a contact is at stake


def choose_panels(recording: Recording) -> list[Panel]:
    """The six moments of the paper's figure, in order of time.

    (a) The first contact; (b) the last moment before (c) in which the pusher descends a detrimental gradient; (c) the
    strongest conflict on the detour, the way without contact that goes farthest around the object; (d) half of the rest
    of that way; (e) the first exploration at a corner after it; (f) the end. Where the episode lacks one, it is a
    moment between the others.

    Raises:
        ComparisonError: If the episode is too short for six panels.
    """
    last = recording.steps
    if last < 6:
        raise ComparisonError(f"the episode has {last} steps; six panels need 6 or more")
    contact = _first(recording.touched, 0, last, otherwise=last // 6)
    begin, end = _detour(recording, contact)
    conflict = _strongest_conflict(recording, begin, end)
    bearings = _bearings(recording)[conflict : end + 1]
    swept = np.abs(bearings - bearings[0])
    around = conflict + _first(swept >= swept[-1] / 2, 1, len(swept), otherwise=1)
    before = np.flatnonzero(_withdrawing(recording)[contact + 1 : conflict])
    harmful = contact + 1 + int(before[-1]) if len(before) else (contact + conflict) // 2
    corner = _first(recording.exploring & at_corners(recording), end, last, otherwise=(end + last) // 2)
    moments = in_order([contact, harmful, conflict, around, corner, last], last)
    return [Panel(*both, _title(recording, *both)) for both in zip("abcdef", moments, strict=True)]


def _title(recording: Recording, letter: str, moment: int) -> str:
    """What a panel shows: the paper's words where they are true, or else the phase."""
    exploring, touched = recording.exploring[moment], recording.touched[moment]
    if letter == "a" and touched and not exploring:
        return "First contact, adjusted in the nullspace"
    if letter == "b" and _withdrawing(recording)[moment]:
        return "Contact turned detrimental: withdrawing"
    if letter == "d" and not touched and not exploring:
        return "Around the object to its far side"
    return phase(recording, moment)


def phase(recording: Recording, moment: int) -> str:
    """What the policy does at a moment, in plain words."""
    if moment == recording.steps:
        return {"arrival": "PartialPath in the goal pose", "time limit": "Out of time"}[recording.ending]
    if recording.exploring[moment]:
        at_corner = at_corners(recording)[moment]
        return "Conflict at a corner: exploring" if at_corner else "Conflict: exploring around the object"
    if _withdrawing(recording)[moment]:
        return "Withdrawing from a detrimental contact"
    return "Pushing a useful contact" if recording.touched[moment] else "Going to a useful contact"


def at_corners(recording: Recording) -> BoolArray:
    """Whether the pusher is near the object and the contact nearest to it is at a corner, (n + 1,)."""
    distances = np.linalg.norm(recording.contacts - recording.pushers[:, np.newaxis], axis=-1)
    nearest = recording.contacts[np.arange(len(distances)), distances.argmin(axis=1)]
    corners = np.stack([recording.corners(moment) for moment in range(len(distances))])
    near_corner = np.linalg.norm(corners - nearest[:, np.newaxis], axis=-1).min(axis=1) < _CORNER
    at_corner: BoolArray = near_corner & (distances.min(axis=1) < PUSHER_RADIUS + _NEAR)
    return at_corner


def summary(recording: Recording, panels: Sequence[Panel]) -> dict[str, Any]:
    """The numbers of the figure."""
    dt = recording.policy.model.dt
    steps = np.linalg.norm(np.diff(recording.pushers, axis=0), axis=1)
    return {
        "seed": recording.seed,
        "ending": recording.ending,
        "steps": recording.steps,
        "duration_s": round(recording.steps * dt, 3),
        "path_length_px": round(float(steps.sum()), 1),
        "pose_error_px": {"start": round(float(recording.costs[0]), 2), "end": round(float(recording.costs[-1]), 2)},
        "panels": [
            {"panel": panel.letter, "time_s": round(panel.step * dt, 3), "title": panel.title} for panel in panels
        ],
        "explorations_s": [
            [round(first * dt, 3), round(end * dt, 3)] for first, end in spans(recording.exploring[:-1])
        ],
    }


def _withdrawing(recording: Recording) -> BoolArray:
    """Whether the pusher descends while the strongest gradient is that of a detrimental contact, (n + 1,)."""
    strongest = recording.strengths.argmax(axis=1)
    withdrawing: BoolArray = ~recording.exploring & ~recording.useful[np.arange(len(strongest)), strongest]
    return withdrawing


def _detour(recording: Recording, contact: int) -> tuple[int, int]:
    """The last moment of one contact and the first of the next, between which the pusher goes farthest around.

    Only ways on which it explores count; without any, the middle third of the time after the first contact.
    """
    bearings = _bearings(recording)
    ways = [
        (first - 1, end)
        for first, end in spans(~recording.touched)
        if first > contact and end <= recording.steps and recording.exploring[first - 1 : end].any()
    ]
    third = (recording.steps - contact) // 3
    return max(
        ways,
        key=lambda way: abs(bearings[way[1]] - bearings[way[0]]),
        default=(contact + third, contact + 2 * third + 1),
    )


def _strongest_conflict(recording: Recording, begin: int, end: int) -> int:
    """The exploring moment, from one on and before another, with the strongest opposition; the first if none explores.

    The opposition is as strong as the weaker of its two sides, the useful and the detrimental contacts.
    """
    weaker = np.minimum(recording.strongest(useful=True), recording.strongest(useful=False))
    return begin + int(np.argmax(np.where(recording.exploring, weaker, -1.0)[begin:end]))


def _bearings(recording: Recording) -> FloatArray:
    """Direction from the object's centre to the pusher, without jumps, (n + 1,), rad."""
    centres = np.stack([recording.corners(moment).mean(axis=0) for moment in range(recording.steps + 1)])
    x, y = (recording.pushers - centres).T
    return np.unwrap(np.arctan2(y, x))


def _first(mask: BoolArray, begin: int, end: int, otherwise: int) -> int:
    """The first true moment from one on and before another."""
    found = np.flatnonzero(mask[begin:end])
    return begin + int(found[0]) if len(found) else otherwise
