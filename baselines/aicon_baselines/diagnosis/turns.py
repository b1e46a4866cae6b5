"""The turns of an episode: along which path each actuator was led, and what stood against what."""

from collections.abc import Iterator
from typing import NamedTuple

from aicon_baselines.diagnosis.history import History
from aicon_baselines.evaluation.recording import runs_of

BRIEF = 0.01
"""Share of the episode below which a turn is not told."""


class Turn(NamedTuple):
    """A time in which the same gradients led; `str` says it in words.

    Attributes:
        begin: Its first moment, s.
        end: The first one after it, s.
        leads: For each actuator the path whose gradient it followed, from a goal on.
        conflicts: For each quantity that explored, the two paths that stood against each other.
    """

    begin: float
    end: float
    leads: tuple[str, ...]
    conflicts: tuple[str, ...]

    def __str__(self) -> str:
        """A line for its time, and one for each path and each conflict."""
        lines = [f"{self.begin:.1f} to {self.end:.1f} s:"]
        lines += [f"  {lead}" for lead in self.leads]
        lines += [f"  exploring {conflict}" for conflict in self.conflicts]
        return "\n".join(lines)


def find_turns(history: History) -> Iterator[Turn]:
    """The turns of an episode, one after the other, without those that were brief."""
    told = [(_leads(history, step), _conflicts(history, step)) for step in range(history.steps)]
    lasting = []
    for begin, end in runs_of(told):
        if end - begin >= BRIEF * history.steps:
            lasting += [(step, told[step]) for step in range(begin, end)]

    # What was interrupted for a moment is one turn.
    for begin, end in runs_of(what for _, what in lasting):
        first, last = lasting[begin][0], lasting[end - 1][0]
        yield Turn(history.dt * first, history.dt * (last + 1), *lasting[begin][1])


def _leads(history: History, step: int) -> tuple[str, ...]:
    return tuple(curve.leads[step] for curve in history.actuators.values())


def _conflicts(history: History, step: int) -> tuple[str, ...]:
    """The two sides of each conflict that is explored."""
    found: list[str] = []
    for name, meeting in history.meetings.items():
        opponent = int(meeting.opponent[step])
        if meeting.exploring[step] and opponent >= 0:
            dominant = int(meeting.dominant[step])
            sides = f"{meeting.labels[dominant]} against {meeting.labels[opponent]}"
            found.append(f"at {name}: {sides}")
    return tuple(found)
