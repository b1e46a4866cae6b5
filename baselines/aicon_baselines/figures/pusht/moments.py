"""The six moments of an episode that the pushing figure shows, and what happens in each."""

import numpy as np

from aicon_baselines.evaluation.recording import BoolArray, FloatArray, true_intervals
from aicon_baselines.figures.pusht.recording import PushRecording
from aicon_baselines.figures.rollout import LABELS, increasing
from aicon_envs.pusht.simulation import PUSHER_RADIUS

_CORNER = 1.0  # px from a corner within which a contact is at it
_NEAR = 10.0  # px between pusher and object within which a contact is at stake

_ENDINGS = {"arrival": "Arrival in the goal pose", "time limit": "Out of time"}


def story(recording: PushRecording) -> tuple[list[int], list[str]]:
    """The steps of the six moments of the paper's figure, and their titles.

    (a) The first contact; (b) the last moment before (c) in which the pusher withdraws from a
    detrimental contact; (c) the strongest conflict on the detour, the trajectory without contact
    that goes farthest around the object; (d) half of the rest of the detour; (e) the first
    exploration at a corner after it; (f) the end. Where the episode lacks one, it is a moment
    between the others.
    """
    last = recording.steps

    # (a) to (d): from the first contact to the far side of the object.
    contact = _first(recording.touched, 0, last, otherwise=last // 6)
    begin, end = _detour(recording, contact)
    conflict = _strongest_conflict(recording, begin, end)
    withdrawal = _last_withdrawal(recording, contact, conflict)
    around = _halfway_around(recording, conflict, end)

    # (e): at a corner of the object.
    conflicts_at_corners = recording.exploring & at_corners(recording)
    corner = _first(conflicts_at_corners, end, last, otherwise=(end + last) // 2)

    # Each in its order, with what is true of it.
    moments = increasing([contact, withdrawal, conflict, around, corner, last], last)
    titles = [_title(recording, *panel) for panel in zip(LABELS, moments, strict=True)]
    return moments, titles


def _title(recording: PushRecording, label: str, moment: int) -> str:
    """What a panel shows: the paper's words where they are true, or else the phase."""
    exploring, touched = recording.exploring[moment], recording.touched[moment]

    if label == "a" and touched and not exploring:
        return "First contact, adjusted in the nullspace"
    if label == "b" and _withdrawing(recording)[moment]:
        return "Contact turned detrimental: withdrawing"
    if label == "d" and not touched and not exploring:
        return "Around the object to its far side"
    return phase(recording, moment)


def phase(recording: PushRecording, moment: int) -> str:
    """What the policy does at a moment, in plain words."""
    if moment == recording.steps:
        return _ENDINGS[recording.ending]

    if recording.exploring[moment]:
        if at_corners(recording)[moment]:
            return "Conflict at a corner: exploring"
        return "Conflict: exploring around the object"

    if _withdrawing(recording)[moment]:
        return "Withdrawing from a detrimental contact"
    if recording.touched[moment]:
        return "Pushing a useful contact"
    return "Going to a useful contact"


def at_corners(recording: PushRecording) -> BoolArray:
    """Whether the pusher is near the object and its nearest contact is at a corner, (n + 1,)."""
    distances = np.linalg.norm(recording.contacts - recording.pushers[:, np.newaxis], axis=-1)
    moments = range(len(distances))
    nearest = recording.contacts[moments, distances.argmin(axis=1)]

    corners = np.stack([recording.corners(moment) for moment in moments])
    to_corners = np.linalg.norm(corners - nearest[:, np.newaxis], axis=-1)

    # Far from the object no contact is at stake.
    near_corner = to_corners.min(axis=1) < _CORNER
    near_object = distances.min(axis=1) < PUSHER_RADIUS + _NEAR
    at_corner: BoolArray = near_corner & near_object
    return at_corner


def _withdrawing(recording: PushRecording) -> BoolArray:
    """Whether it descends while a detrimental contact's gradient is the strongest, (n + 1,)."""
    strongest = recording.strengths.argmax(axis=1)
    useful = recording.useful[np.arange(len(strongest)), strongest]
    withdrawing: BoolArray = ~recording.exploring & ~useful
    return withdrawing


def _detour(recording: PushRecording, contact: int) -> tuple[int, int]:
    """The last moment of one contact and the first of the next, farthest apart around the object.

    Only detours on which it explores count; without any, the middle third of the time after the
    first contact.
    """
    bearings = _bearings(recording)
    third = (recording.steps - contact) // 3
    detour = (contact + third, contact + 2 * third + 1)
    widest = -1.0

    for begin, end in true_intervals(~recording.touched):
        before = begin - 1
        between_contacts = begin > contact and end <= recording.steps
        if not (between_contacts and recording.exploring[before:end].any()):
            continue

        # The first of the widest.
        angle = abs(float(bearings[end] - bearings[before]))
        if angle > widest:
            detour, widest = (before, end), angle

    return detour


def _strongest_conflict(recording: PushRecording, begin: int, end: int) -> int:
    """The exploring moment, from one on and before another, with the strongest opposition.

    The opposition is as strong as the weaker of its two sides, the useful and the detrimental
    contacts. If no moment explores, it is the first one.
    """
    weaker = np.minimum(recording.strongest(useful=True), recording.strongest(useful=False))
    opposition = np.where(recording.exploring, weaker, -1.0)
    return begin + int(opposition[begin:end].argmax())


def _last_withdrawal(recording: PushRecording, contact: int, conflict: int) -> int:
    """The last moment between two others in which the pusher withdraws, or else half-way."""
    withdrawals = np.flatnonzero(_withdrawing(recording)[contact + 1 : conflict])
    if len(withdrawals):
        return contact + 1 + int(withdrawals[-1])
    return (contact + conflict) // 2


def _halfway_around(recording: PushRecording, begin: int, end: int) -> int:
    """The moment between two others by which half of the angle around the object is covered."""
    bearings = _bearings(recording)[begin : end + 1]
    angles = np.abs(bearings - bearings[0])
    return begin + _first(angles >= angles[-1] / 2, 1, len(angles), otherwise=1)


def _bearings(recording: PushRecording) -> FloatArray:
    """Direction from the object's centre to the pusher, without jumps, (n + 1,), rad."""
    moments = range(recording.steps + 1)
    centers = np.stack([recording.corners(moment).mean(axis=0) for moment in moments])
    x, y = (recording.pushers - centers).T
    return np.unwrap(np.arctan2(y, x))


def _first(mask: BoolArray, begin: int, end: int, otherwise: int) -> int:
    """The first true moment from one on and before another."""
    found = np.flatnonzero(mask[begin:end])
    return begin + int(found[0]) if len(found) else otherwise
