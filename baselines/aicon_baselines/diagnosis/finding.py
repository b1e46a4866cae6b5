"""A finding: one thing that is seen in a recorded episode."""

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
