"""The plan of a backward pass: what arrives where, from where, and in which order."""

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from aicon_torch.graph import Edge, WorldModel
from aicon_torch.resolution import Resolution


class PartialPath(NamedTuple):
    """The part of a path from its goal to some quantity.

    Attributes:
        names: What it leads through, the goal first. Where gradients were merged on the way, their
            goals stand joined by "+", followed by the quantity of the merger.
        goals: The goals that it comes from.
    """

    names: tuple[str, ...]
    goals: frozenset[str]

    def __str__(self) -> str:
        """``reach → p_tar → x_rob``."""
        return " → ".join(self.names)


class Arrival(NamedTuple):
    """What one edge brings to a quantity: a gradient, or one for each row.

    Attributes:
        edge: The edge.
        path: The path so far.
        block: Which block of the stack it belongs to; what belongs to the same is summed.
    """

    edge: Edge
    path: PartialPath
    block: int


class Turn(NamedTuple):
    """What is pulled back at once: one gradient of each of some quantities.

    Attributes:
        leaving: The quantities, and which of the gradients that leave each.
        edges: The edges along which these go, in the order in which they arrive.
    """

    leaving: tuple[tuple[str, int], ...]
    edges: tuple[Edge, ...]


class Level(NamedTuple):
    """Goals and quantities that need gradients of the levels before theirs only.

    Attributes:
        names: The goals and quantities.
        turns: How what leaves them is pulled back.
    """

    names: tuple[str, ...]
    turns: tuple[Turn, ...]


class Plan:
    """The order in which gradients travel from the goals to the actuators.

    Args:
        model: The world model.
        resolution: Says where gradients are merged.
        goals: The goals whose gradients travel.

    Attributes:
        levels: One after the other, so that everything has arrived at a quantity before anything
            leaves it.
        arrivals: For each quantity what arrives there, in this order.
        paths: For each quantity the path of each gradient of its stack.
    """

    def __init__(self, model: WorldModel, resolution: Resolution, goals: Sequence[str]) -> None:
        self.model, self.resolution = model, resolution
        self.levels: list[Level] = []
        self.arrivals: dict[str, list[Arrival]] = {}

        # Level by level all has arrived when a quantity's turn comes, so what leaves it is known.
        leaving = {goal: [PartialPath((goal,), frozenset([goal]))] for goal in goals}
        for names in _by_depth(model, goals):
            for name in names:
                if name in self.arrivals:
                    leaving[name] = self._leaving(name, _paths_of(self.arrivals[name]))

            level = Level(tuple(names), tuple(self._turns(names, leaving)))
            self.levels.append(level)
            for turn in level.turns:
                self._arrive(turn, leaving)

        self.paths = {name: _paths_of(arrivals) for name, arrivals in self.arrivals.items()}

    def comes_by_rows(self, name: str) -> bool:
        """Whether an edge brings a gradient for each row to a quantity."""
        return any(arrival.edge.rows for arrival in self.arrivals.get(name, ()))

    def _turns(
        self, names: Sequence[str], leaving: Mapping[str, Sequence[PartialPath]]
    ) -> Iterator[Turn]:
        """The first gradient of each quantity of a level, then the second of each that has one."""
        for index in range(max(len(leaving[name]) for name in names)):
            having = [name for name in names if index < len(leaving[name])]
            edges = [edge for name in having for edge in self.model.edges[name]]
            yield Turn(tuple((name, index) for name in having), tuple(edges))

    def _arrive(self, turn: Turn, leaving: Mapping[str, Sequence[PartialPath]]) -> None:
        """Note what a turn brings to whom."""
        index_of = dict(turn.leaving)
        for edge in turn.edges:
            path = leaving[edge.target][index_of[edge.target]]
            here = self.arrivals.setdefault(edge.source, [])
            here.append(Arrival(edge, path, self._block_of(edge, here)))

    def _block_of(self, edge: Edge, earlier: Sequence[Arrival]) -> int:
        """Gradients of the same rows are summed if the resolution says so; others stand alone."""
        # Rows that go back to one quantity belong together, through whatever edges they come.
        if self.resolution.by_row and edge.rows:
            for arrival in earlier:
                if arrival.edge.rows and arrival.edge.rows_of == edge.rows_of:
                    return arrival.block
        return 1 + max((arrival.block for arrival in earlier), default=-1)

    def _leaving(self, name: str, paths: list[PartialPath]) -> list[PartialPath]:
        """The paths that leave a quantity: one where its gradients are merged, else all."""
        if not self.resolution.merges or len(paths) == 1:
            return [path._replace(names=(*path.names, name)) for path in paths]

        goals = frozenset().union(*(path.goals for path in paths))
        joined = "+".join(goal for goal in self.model.goals if goal in goals)
        return [PartialPath((joined, name), goals)]


def _by_depth(model: WorldModel, goals: Sequence[str]) -> list[list[str]]:
    """Goals and quantities in the order of the pass: the longest way from a goal counts."""
    # Estimators run from the actuators to the goals; gradients go the other way.
    names = list(goals)
    for estimator in reversed(model.estimators):
        names.extend(name for name in estimator.outputs if name in model.edges)

    depth = dict.fromkeys(goals, 0)
    for name in names:
        if name not in depth:
            continue  # only safety goals depend on it
        for edge in model.edges[name]:
            depth[edge.source] = max(depth.get(edge.source, 0), depth[name] + 1)

    levels: dict[int, list[str]] = {}
    for name in filter(depth.__contains__, names):
        levels.setdefault(depth[name], []).append(name)
    return [levels[level] for level in sorted(levels)]


def _paths_of(arrivals: Sequence[Arrival]) -> list[PartialPath]:
    """The path of each gradient of a stack; in a sum, those of its terms joined."""
    # An edge with rows brings a path for each; where blocks are summed, two paths become one.
    blocks: dict[int, list[PartialPath]] = {}
    for edge, path, block in arrivals:
        paths = [path]
        if edge.rows:
            paths = [PartialPath((*path.names[:-1], row), path.goals) for row in edge.labels]
        if block in blocks:
            pairs = zip(blocks[block], paths, strict=False)
            paths = [_joined(first, second) for first, second in pairs]
        blocks[block] = paths

    stacked: list[PartialPath] = []
    for paths in blocks.values():
        stacked.extend(paths)
    return stacked


def _joined(first: PartialPath, second: PartialPath) -> PartialPath:
    """The path of a sum of two gradients: what they have in common from the goal on, then both."""
    goals = first.goals | second.goals
    if first.names[:-1] == second.names[:-1]:
        ends = f"{first.names[-1]}+{second.names[-1]}"
        return PartialPath((*first.names[:-1], ends), goals)
    return PartialPath((f"{first} + {second}",), goals)
