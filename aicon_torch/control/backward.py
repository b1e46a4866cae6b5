"""The backward pass: gradients travel from the goals to the actuators, resolved wherever they meet.

Backpropagation adds up what arrives at a node. Here a resolution decides what goes on instead.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

import torch
from torch import Tensor

from aicon_torch.errors import OptionError, choices
from aicon_torch.graph import Edge, LocalGraphs, WorldModel
from aicon_torch.resolution import GradientStack, Memory, Resolution


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


class IncomingEdge(NamedTuple):
    """What one edge brings to a quantity: a gradient, or one for each row.

    Attributes:
        edge: The edge.
        path: The path so far.
        group: Which block of the stack it belongs to; what belongs to the same is summed.
    """

    edge: Edge
    path: PartialPath
    group: int


class BackwardPass:
    """Pulls the gradients of the goals back to the actuators, edge by edge.

    Safety goals are not among them: they bound the actions instead.

    With a resolution that merges, one gradient leaves each quantity, and the cost of a pass grows
    with the edges. Otherwise every path is followed to its end (Eq. 1), and the cost grows with the
    paths.

    Args:
        model: The world model.
        resolution: What happens where gradients meet.

    Attributes:
        levels: Goals and quantities in the order of the pass: each level needs gradients of the
            levels before it only.
        paths: For each quantity the path of each gradient of its stack, in this order.

    Raises:
        OptionError: If the resolution names a goal that the model does not have.
    """

    def __init__(self, model: WorldModel, resolution: Resolution) -> None:
        for goal in resolution.goals:
            if goal not in model.goals:
                raise OptionError(
                    f"The resolution names the goal {goal!r}. Goals: {choices(model.goals)}."
                )
        self.model, self.resolution = model, resolution
        self.goals = tuple(name for name, goal in model.goals.items() if not goal.safety)

        # What arrives where, and along which paths.
        self.levels = _levels(model, self.goals)
        self._incoming = self._follow_edges()
        self.paths = {name: _paths_of(incoming) for name, incoming in self._incoming.items()}

        # Where gradients are resolved, and what is remembered there.
        self._is_last = self._find_last_mergers()
        self._remembered = {
            name: tuple(self._initial_at(name)) for name in self.paths if self.resolves_at(name)
        }

    def resolves_at(self, name: str) -> bool:
        """Whether several gradients arrive at this quantity and are resolved there."""
        acts_here = self.resolution.merges or name in self.model.actuators
        return acts_here and len(self.paths.get(name, ())) > 1

    def initial(self) -> Memory:
        """What is remembered of every quantity before the first step, without batch dimensions."""
        memory: Memory = {}
        for name in self._remembered:
            for key, value in self._initial_at(name).items():
                memory[f"{name}/{key}"] = value
        for name, actuator in self.model.actuators.items():
            memory[f"{name}/gradient"] = torch.zeros(actuator.size)
        return memory

    def __call__(
        self,
        graphs: LocalGraphs,
        values: Mapping[str, Tensor],
        memory: Mapping[str, Tensor],
        goal_factors: Tensor,
        costs: dict[str, Tensor],
    ) -> tuple[dict[str, Tensor], Memory]:
        """Travel once from the goals to the actuators.

        Args:
            graphs: The local graphs to travel through.
            values: Values after the step.
            memory: Memory before the step.
            goal_factors: Factor of each goal, ``(*B, goals)``.
            costs: Cost of each goal after the step, ``(*B,)``.

        Returns:
            The gradient at each actuator ``(*B, size)``, and the new memory of every quantity.
        """
        arrived: dict[str, list[Tensor]] = {name: [] for name in self.paths}
        new_memory: Memory = {}

        def outgoing(name: str) -> list[Tensor]:
            """The gradients that leave a quantity: what they are resolved to, or each by itself."""
            if not self.resolves_at(name):
                return self._unresolved(name, arrived[name])
            stack = self._stack(name, arrived[name], values, memory, costs)
            resolved, remembered = self.resolution(stack, self._recall(name, memory))
            for key, value in (*remembered.items(), ("gradients", stack.gradients)):
                new_memory[f"{name}/{key}"] = value
            return [resolved.reshape(values[name].shape)]

        # A goal's own gradient is its factor.
        for goal, factor in zip(self.model.goals, goal_factors.unbind(-1), strict=True):
            if goal in self.goals:
                arrived[goal] = [factor]

        # Level by level: resolve, then pull back along every edge (Eq. 1).
        for level in self.levels:
            gradients = {name: outgoing(name) for name in level}
            for turn in _turns(level, gradients):
                leaving = {name: gradients[name][index] for name, index in turn.items()}
                pulled = iter(self._pull_back(graphs, leaving))
                for name in turn:
                    for edge in self.model.edges[name]:
                        arrived[edge.source].append(next(pulled))

        # Resolve what arrives at the actuators.
        actions = {name: outgoing(name)[0] for name in self.model.actuators}
        for name, gradient in actions.items():
            new_memory[f"{name}/gradient"] = gradient
        return actions, new_memory

    def _follow_edges(self) -> dict[str, list[IncomingEdge]]:
        """What arrives at each quantity, in the order of the pass."""
        incoming: dict[str, list[IncomingEdge]] = {}
        leaving: dict[str, list[PartialPath]] = {}
        for goal in self.goals:
            leaving[goal] = [PartialPath((goal,), frozenset([goal]))]

        # Level by level, so that everything has arrived at a quantity before anything leaves it.
        for level in self.levels:
            for name in level:
                if name in incoming:
                    leaving[name] = self._leaving(name, _paths_of(incoming[name]))
            for turn in _turns(level, leaving):
                for name, index in turn.items():
                    for edge in self.model.edges[name]:
                        here = incoming.setdefault(edge.source, [])
                        group = self._group_of(edge, here)
                        here.append(IncomingEdge(edge, leaving[name][index], group))
        return incoming

    def _group_of(self, edge: Edge, earlier: Sequence[IncomingEdge]) -> int:
        """Gradients of the same rows are summed if the resolution says so; others stand alone."""
        if self.resolution.by_row and edge.rows:
            for arriving in earlier:
                if arriving.edge.rows and arriving.edge.rows_of == edge.rows_of:
                    return arriving.group
        return 1 + max((arriving.group for arriving in earlier), default=-1)

    def _leaving(self, name: str, paths: list[PartialPath]) -> list[PartialPath]:
        """The paths that leave a quantity: one where its gradients are merged, else all."""
        if not self.resolution.merges or len(paths) == 1:
            return [path._replace(names=(*path.names, name)) for path in paths]

        goals = frozenset().union(*(path.goals for path in paths))
        joined = "+".join(goal for goal in self.model.goals if goal in goals)
        return [PartialPath((joined, name), goals)]

    def _find_last_mergers(self) -> dict[str, bool]:
        """For each quantity whether gradients meet nowhere else on the way to the actuators."""
        is_last = dict.fromkeys(self.model.actuators, True)
        for level in reversed(self.levels):
            for name in level:
                sources = [edge.source for edge in self.model.edges[name]]
                is_last[name] = all(
                    is_last[source] and not self.resolves_at(source) for source in sources
                )
        return is_last

    def _initial_at(self, name: str) -> Memory:
        """What is remembered of one quantity: by the resolution, and what arrived there."""
        count, size = len(self.paths[name]), self.model.quantities[name].size
        gradients = torch.zeros(count, size)
        return {**self.resolution.initial(count, size), "gradients": gradients}

    def remembered_at(self, name: str) -> tuple[str, ...]:
        """What is remembered of a quantity, by the keys that follow its name and a slash."""
        return self._remembered[name]

    def _recall(self, name: str, memory: Mapping[str, Tensor]) -> Memory:
        return {key: memory[f"{name}/{key}"] for key in self._remembered[name]}

    def _unresolved(self, name: str, arrived: Sequence[Tensor]) -> list[Tensor]:
        """The gradients ``(*B, *shape)`` one by one; those that came row by row are taken apart."""
        if not any(arriving.edge.rows for arriving in self._incoming.get(name, ())):
            return list(arrived)

        shape = self.model.quantities[name].shape
        gradients = self._stacked(name, arrived).unbind(-2)
        return [gradient.reshape(*gradient.shape[:-1], *shape) for gradient in gradients]

    def _stack(
        self,
        name: str,
        arrived: Sequence[Tensor],
        values: Mapping[str, Tensor],
        memory: Mapping[str, Tensor],
        costs: dict[str, Tensor],
    ) -> GradientStack:
        """The gradients that meet at a quantity, and what is known there."""
        quantity, value = self.model.quantities[name], values[name]
        motion = value if quantity.is_motion else value - memory[name]

        def displaced_cost(goal: str, displacement: Tensor) -> Tensor:
            shift = displacement.reshape(value.shape)
            return self.model.displaced_cost(goal, name, shift, values)

        return GradientStack(
            gradients=self._stacked(name, arrived),
            goals=tuple(path.goals for path in self.paths[name]),
            motion=quantity.flatten(motion),
            costs=costs,
            displaced_cost=displaced_cost,
            dt=self.model.dt,
            is_last=self._is_last[name],
        )

    def _stacked(self, name: str, arrived: Sequence[Tensor]) -> Tensor:
        """The gradients that arrived as rows ``(*B, n, d)``; those of one group are summed."""
        quantity = self.model.quantities[name]
        incoming = self._incoming[name]
        if not any(arriving.edge.rows for arriving in incoming):
            return torch.stack([quantity.flatten(gradient) for gradient in arrived], dim=-2)

        blocks: dict[int, Tensor] = {}
        for arriving, gradient in zip(incoming, arrived, strict=True):
            if not arriving.edge.rows:
                gradient = quantity.flatten(gradient).unsqueeze(-2)
            if arriving.group in blocks:
                gradient = blocks[arriving.group] + gradient
            blocks[arriving.group] = gradient
        return torch.cat(list(blocks.values()), dim=-2)

    @staticmethod
    def _pull_back(graphs: LocalGraphs, gradients: Mapping[str, Tensor]) -> tuple[Tensor, ...]:
        """(∂x/∂source)ᵀ ∇ₓ for every edge of some quantities x at once: a factor of Eq. 1 each.

        No two local graphs share a leaf, so their derivatives do not mix.
        """
        outputs: list[Tensor] = []
        leaves: list[Tensor] = []
        for name in gradients:
            outputs.append(graphs[name].output)
            leaves.extend(graphs[name].leaves)

        seeds = list(gradients.values())
        return torch.autograd.grad(outputs, leaves, seeds, retain_graph=True)


def _paths_of(incoming: Sequence[IncomingEdge]) -> list[PartialPath]:
    """The path of each gradient of a stack; in a sum, those of its terms joined."""
    blocks: dict[int, list[PartialPath]] = {}
    for edge, path, group in incoming:
        paths = [path]
        if edge.rows:
            paths = [PartialPath((*path.names[:-1], row), path.goals) for row in edge.labels]
        if group in blocks:
            pairs = zip(blocks[group], paths, strict=False)
            paths = [_joined(first, second) for first, second in pairs]
        blocks[group] = paths

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


def _levels(model: WorldModel, goals: Sequence[str]) -> list[list[str]]:
    """Goals and quantities in the order of the pass: the longest way from a goal counts."""
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


def _turns(
    level: Iterable[str], leaving: Mapping[str, Sequence[object]]
) -> Iterator[dict[str, int]]:
    """Turns in which what leaves a level is pulled back: for each name which of its is next."""
    names = list(level)
    for turn in range(max(len(leaving[name]) for name in names)):
        yield {name: turn for name in names if turn < len(leaving[name])}
