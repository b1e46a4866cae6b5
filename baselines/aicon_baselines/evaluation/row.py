"""One row of `episodes.csv`: what became of one episode."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, NamedTuple


class Row(NamedTuple):
    """The outcome of one episode; the first four fields name it and are the order of the file."""

    policy: str
    condition: str
    repeat: int
    seed: int
    map: str
    success: bool
    steps: int | None
    """Step at which the episode succeeded; None if it did not."""
    collision: bool
    path_length: float
    """Length of the path taken, in the task's unit."""
    shortest_path_length: float | None
    """Length of the shortest path without collision, in the task's unit; None if it has none."""
    distance: float
    """Distance to the target at the end, in the task's unit."""
    measures: Mapping[str, float] = MappingProxyType({})
    """What else the task measures."""

    def to_fields(self) -> list[str]:
        """Write the row as text: truth values as 0 and 1, six decimals, nothing for None."""
        return [_to_text(value) for value in self]

    @classmethod
    def from_fields(cls, fields: list[str]) -> "Row":
        """Read a row back from its text; ValueError if it is not one."""
        named = dict(zip(cls._fields, fields, strict=True))
        shortest = named["shortest_path_length"]

        measures = {}
        for text in named["measures"].split():
            name, _, value = text.partition("=")
            measures[name] = float(value)

        return cls(
            policy=named["policy"],
            condition=named["condition"],
            repeat=int(named["repeat"]),
            seed=int(named["seed"]),
            map=named["map"],
            success=bool(int(named["success"])),
            steps=int(named["steps"]) if named["steps"] else None,
            collision=bool(int(named["collision"])),
            path_length=float(named["path_length"]),
            shortest_path_length=float(shortest) if shortest else None,
            distance=float(named["distance"]),
            measures=measures,
        )


def _to_text(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(int(value))
    if isinstance(value, float):
        return f"{value:.6f}"
    if isinstance(value, Mapping):
        return " ".join(f"{name}={number:.6f}" for name, number in value.items())
    return str(value)


Key = tuple[str, str, int, int]


def key(row: Row) -> Key:
    """Return what names an episode of a run, and orders the file."""
    return row.policy, row.condition, row.repeat, row.seed
