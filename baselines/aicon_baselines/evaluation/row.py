"""One row of `episodes.csv`: what became of one episode."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple


class Row(NamedTuple):
    """The outcome of one episode; the first four fields say which one it was and are the order of the file."""

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
    """Length of the shortest collision-free path, in the task's unit; None if the task has no such path."""
    distance: float
    """Distance to the target at the end, in the task's unit."""
    measures: Mapping[str, float] = MappingProxyType({})
    """What else the task measures."""

    def to_fields(self) -> list[str]:
        """Write the row as text: truth values as 0 and 1, lengths to six decimals, nothing for None."""
        return [
            self.policy,
            self.condition,
            str(self.repeat),
            str(self.seed),
            self.map,
            str(int(self.success)),
            "" if self.steps is None else str(self.steps),
            str(int(self.collision)),
            f"{self.path_length:.6f}",
            "" if self.shortest_path_length is None else f"{self.shortest_path_length:.6f}",
            f"{self.distance:.6f}",
            " ".join(f"{name}={value:.6f}" for name, value in self.measures.items()),
        ]

    @classmethod
    def from_fields(cls, fields: list[str]) -> "Row":
        """Read a row back from its text; ValueError if it is not one."""
        policy, condition, repeat, seed, name, success, steps, collision, path, shortest, distance, measures = fields
        return cls(
            policy=policy,
            condition=condition,
            repeat=int(repeat),
            seed=int(seed),
            map=name,
            success=bool(int(success)),
            steps=int(steps) if steps else None,
            collision=bool(int(collision)),
            path_length=float(path),
            shortest_path_length=float(shortest) if shortest else None,
            distance=float(distance),
            measures={name: float(value) for name, _, value in (text.partition("=") for text in measures.split())},
        )


Key = tuple[str, str, int, int]


def key(row: Row) -> Key:
    """Return (policy, condition, repeat, seed), which names an episode of a run and orders the file."""
    return row.policy, row.condition, row.repeat, row.seed
