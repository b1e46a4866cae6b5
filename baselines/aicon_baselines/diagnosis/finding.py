"""A finding: one thing that is seen in a recorded episode, and numbers in words for its text."""

from collections.abc import Sequence
from typing import Literal, NamedTuple

Kind = Literal[
    "cycle",
    "standstill",
    "progress",
    "wandering",
    "silence",
    "disagreement",
    "conflict",
    "constraint",
    "limit",
    "restlessness",
]
"""What a finding is: the first four say what the robot did, the others why."""


class Finding(NamedTuple):
    """One thing that is seen in a recorded episode.

    Attributes:
        kind: What it is.
        text: The same in words, with its numbers.
        begin: Since when it is seen, s.
        subjects: The goals, quantities, actuators or sensors that it is about.
        period: Of a cycle, s.
    """

    kind: Kind
    text: str
    begin: float
    subjects: tuple[str, ...] = ()
    period: float | None = None


def seconds(time: float) -> str:
    """``"3.4 s"``, ``"250 s"``."""
    return f"{time:.1f} s" if time < 100 else f"{time:.0f} s"


def times(count: int) -> str:
    """``"once"``, ``"twice"``, ``"3 times"``."""
    return {1: "once", 2: "twice"}.get(count, f"{count} times")


def percent(share: float) -> str:
    """``"64 %"``."""
    return f"{share:.0%}".replace("%", " %")


def listed(names: Sequence[str]) -> str:
    """``"a, b and c"``."""
    if len(names) < 2:
        return "".join(names)
    return f"{', '.join(names[:-1])} and {names[-1]}"
