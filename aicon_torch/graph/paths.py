"""Paths: the chains goal → quantity → … → actuator along which gradients travel (Eq. 1)."""

from collections.abc import Iterator, Mapping
from functools import cache
from itertools import islice
from typing import NamedTuple

MOST_SHOWN = 100
"""So many paths a console shows."""


class Edge(NamedTuple):
    """One factor of the chain rule: the gradient of ``target`` goes on to ``source``.

    Attributes:
        target: The quantity or goal that the gradient leaves.
        source: The quantity that it arrives at.
        rows: Number of gradients that arrive, one for each row of the target; 0 where it is one
            gradient.
        rows_of: The quantity that the target's rows go back to.
    """

    target: str
    source: str
    rows: int = 0
    rows_of: str = ""

    @property
    def labels(self) -> tuple[str, ...]:
        """The target, or each of its rows: ``("x[0]", "x[1]", …)``."""
        if not self.rows:
            return (self.target,)
        return tuple(f"{self.target}[{row}]" for row in range(self.rows))


class Path(NamedTuple):
    """A path p: g ⇝ a."""

    goal: str
    quantities: tuple[str, ...]
    actuator: str

    def __str__(self) -> str:
        """``reach → p_tar → x_rob → a``."""
        return " → ".join((self.goal, *self.quantities, self.actuator))


class PathTable:
    """All paths of a graph, enumerated lazily: their number can double with every layer.

    Args:
        edges: The edges of each goal and quantity.
        goals: Names of the goals, in order.
        actuators: Names of the actuators.
    """

    def __init__(
        self,
        edges: Mapping[str, tuple[Edge, ...]],
        goals: tuple[str, ...],
        actuators: tuple[str, ...],
    ) -> None:
        self._edges, self._goals, self._actuators = edges, goals, actuators

    def __iter__(self) -> Iterator[Path]:
        """Paths, goal by goal."""
        for goal in self._goals:
            yield from self._walk(goal, (goal,))

    def __len__(self) -> int:
        """Number of paths, as far as Python's ``len`` counts."""
        return self.count()

    def count(self) -> int:
        """Number of paths, counted along the edges without enumerating them."""

        @cache
        def below(name: str) -> int:
            # An actuator ends one path; elsewhere each edge, or each row, has those that go on.
            if name in self._actuators:
                return 1
            return sum(len(edge.labels) * below(edge.source) for edge in self._edges[name])

        return sum(below(goal) for goal in self._goals)

    def __str__(self) -> str:
        """One path a line."""
        return "\n".join(map(str, self))

    def __repr__(self) -> str:
        """What a console shows of it: one path a line, the first hundred of them."""
        lines = [str(path) for path in islice(self, MOST_SHOWN)]
        if self.count() > MOST_SHOWN:
            lines.append(f"… {self.count()} paths in all")
        return "\n".join(lines)

    def _walk(self, name: str, trail: tuple[str, ...]) -> Iterator[Path]:
        if name in self._actuators:
            yield Path(trail[0], trail[1:-1], name)
            return
        for edge in self._edges[name]:
            # The row that it leaves by stands in the path for the whole quantity.
            for label in edge.labels:
                yield from self._walk(edge.source, (*trail[:-1], label, edge.source))
