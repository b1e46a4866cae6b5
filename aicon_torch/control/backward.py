"""The sweep: gradients travel from the goals to the actuators and are resolved wherever they meet."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

import torch
from torch import Tensor

from aicon_torch.errors import OptionError, choices
from aicon_torch.graph import LocalGraphs, WorldModel
from aicon_torch.resolution import GradientStack
from aicon_torch.graph import Edge
from aicon_torch.quantities import Quantity
from aicon_torch.resolution import Memory, Resolution


class PartialPath(NamedTuple):
    """A gradient that arrives at a quantity: the names it came through, goal first, and the goals it comes from.

    Where several gradients were merged on the way, their goals stand joined, followed by the quantity of the merger,
    and its rank there if it is one of those that left it; `order` has both.
    """

    trace: tuple[str, ...]
    goals: frozenset[str]
    order: tuple[str, int] | None = None

    def __str__(self) -> str:
        """``reach → p_tar → x_rob``."""
        return " → ".join(self.trace)


class BackwardPass:
    """Pulls the gradients of all goals back to the actuators, edge by edge.

    With a merging resolution one gradient leaves each quantity, and the cost of a sweep grows with the edges. Otherwise
    every path is followed to its end (Eq. 1), and the cost grows with the paths.

    Args:
        model: The world model.
        resolution: What happens where gradients meet.

    Attributes:
        arrivals: For each quantity the gradients that arrive there, in the order of the stack.
        blocks: For each quantity the edges that they come along, in this order; one may bring several, row by row.
    """

    def __init__(self, model: WorldModel, resolution: Resolution) -> None:
        for goal in resolution.goals:
            if goal not in model.goals:
                raise OptionError(f"The resolution names the goal {goal!r}. Goals: {choices(model.goals)}.")
        self.model, self.resolution = model, resolution
        self.levels = _levels(model)
        self.final: dict[str, bool] = {}
        self._follow()
        self.final = self._find_final()
        if resolution.inherits:
            self._follow()
        self.siblings = {name: _related(here, lambda i, j: i != j) for name, here in self.arrivals.items()}
        self.before = {name: _related(here, lambda i, j: j < i) for name, here in self.arrivals.items()}
        self.remembered = {name: tuple(self._initial(name)) for name in self.arrivals if self.meets(name)}

    def _follow(self) -> None:
        """Note what arrives where; as long as it is not known which meetings are final, all are taken for it."""
        self.arrivals: dict[str, list[PartialPath]] = {}
        self.blocks: dict[str, list[Edge]] = {}
        model = self.model
        leaving = {goal: [PartialPath((goal,), frozenset([goal]))] for goal in model.goals}
        for level in self.levels:
            leaving |= {name: self._leaving(name) for name in level if name in self.arrivals}
            for names in _rounds(level, leaving):
                for name in names:
                    for edge in model.edges[name]:
                        self._announce(edge, leaving[name][names[name]])

    def _announce(self, edge: Edge, arrival: PartialPath) -> None:
        """Note what an edge brings to its source when it is pulled once."""
        here = self.arrivals.setdefault(edge.source, [])
        self.blocks.setdefault(edge.source, []).append(edge)
        if not edge.rows:
            here.append(arrival)
            return
        rows = [arrival._replace(trace=(*arrival.trace[:-1], label)) for label in edge.labels]
        start = self._joined(edge)
        if start is None:
            here.extend(rows)
        else:  # summed with those that came before, row by row
            here[start : start + edge.rows] = [
                PartialPath(_joined(old.trace, new.trace), old.goals | new.goals)
                for old, new in zip(here[start:], rows, strict=False)
            ]

    def _joined(self, edge: Edge) -> int | None:
        """Where the candidates begin with which the rows of the latest edge are summed, if there are any."""
        start, seen = 0, set()
        for block in self.blocks[edge.source][:-1]:
            if self.resolution.by_row and block.rows and block.rows_of == edge.rows_of:
                return start
            if block.rows_of not in seen or not (self.resolution.by_row and block.rows):
                start += block.rows or 1
            seen.add(block.rows_of)
        return None

    def _leaving(self, name: str) -> list[PartialPath]:
        here = self.arrivals[name]
        if not self.resolution.merges or len(here) == 1:
            return [arrival._replace(trace=(*arrival.trace, name)) for arrival in here]
        goals = frozenset().union(*(arrival.goals for arrival in here))
        joined = "+".join(goal for goal in self.model.goals if goal in goals)
        if not self.resolution.inherits or self.final.get(name, True):
            return [PartialPath((joined, name), goals)]
        ranks = self.resolution.ranks(len(here), self.model.quantities[name].size)
        return [PartialPath((joined, f"{name} (rank {rank})"), goals, (name, rank)) for rank in range(ranks)]

    def _find_final(self) -> dict[str, bool]:
        """For each quantity whether gradients meet nowhere else on the way from there to the actuators."""
        final = dict.fromkeys(self.model.actuators, True)
        for level in reversed(self.levels):
            for name in level:
                sources = [edge.source for edge in self.model.edges[name]]
                final[name] = all(final[source] and not self.meets(source) for source in sources)
        return final

    def meets(self, name: str) -> bool:
        """Whether gradients are resolved at this quantity."""
        return len(self.arrivals.get(name, ())) > 1 and (self.resolution.merges or name in self.model.actuators)

    def initial(self) -> Memory:
        """What is remembered of every meeting before the first step, without batch dimensions."""
        memory = {f"{name}/{key}": value for name in self.remembered for key, value in self._initial(name).items()}
        return memory | {f"{name}/gradient": torch.zeros(a.size) for name, a in self.model.actuators.items()}

    def _initial(self, name: str) -> Memory:
        candidates, size = len(self.arrivals[name]), self.model.quantities[name].size
        return {**self.resolution.initial(candidates, size), "gradients": torch.zeros(candidates, size)}

    def __call__(
        self, tapes: LocalGraphs, values: Mapping[str, Tensor], before: Mapping[str, Tensor], active: Tensor
    ) -> tuple[dict[str, Tensor], Memory]:
        """BackwardPass once.

        Args:
            tapes: The tapes of this step.
            values: Values after the step.
            before: Memory before the step, the state of every meeting included.
            active: Factor of each goal, ``(*B, goals)``.

        Returns:
            The gradient at each actuator ``(*B, size)``, and the new state of every meeting.
        """
        costs = {name: tapes[name].output.detach() for name in self.model.goals}  # as numbers, to compare over time
        arrived: dict[str, list[Tensor]] = {name: [] for name in self.arrivals}
        arrived |= {name: [factor] for name, factor in zip(self.model.goals, active.unbind(-1), strict=True)}
        memory: Memory = {}

        def leaving(name: str) -> list[Tensor]:
            if not self.meets(name):
                return self._apart(name, arrived[name])
            resolved, state = self._resolve(name, arrived[name], values, before, costs)
            memory.update(state)
            return resolved

        for level in self.levels:
            gradients = {name: leaving(name) for name in level}
            for names in _rounds(level, gradients):
                pulled = iter(self._pull(tapes, {name: gradients[name][turn] for name, turn in names.items()}))
                for name in names:
                    for edge in self.model.edges[name]:
                        arrived[edge.source].append(next(pulled))
        actions = {name: leaving(name)[0] for name in self.model.actuators}
        return actions, memory | {f"{name}/gradient": gradient for name, gradient in actions.items()}

    def _apart(self, name: str, arrived: Sequence[Tensor]) -> list[Tensor]:
        """The gradients ``(*B, *shape)`` one by one; those that came row by row are taken apart."""
        if not any(edge.rows for edge in self.blocks.get(name, ())):
            return list(arrived)
        quantity = self.model.quantities[name]
        gradients = self._stack(quantity, arrived).unbind(-2)
        return [gradient.reshape(*gradient.shape[:-1], *quantity.shape) for gradient in gradients]

    def _stack(self, quantity: Quantity, arrived: Sequence[Tensor]) -> Tensor:
        """The gradients that arrived as one stack, ``(*B, n, d)``."""
        blocks = self.blocks[quantity.name]
        if not any(edge.rows for edge in blocks):
            return torch.stack([quantity.flatten(gradient) for gradient in arrived], dim=-2)
        stacks: dict[str | int, Tensor] = {}
        for index, (block, edge) in enumerate(zip(arrived, blocks, strict=True)):
            stack = block if edge.rows else quantity.flatten(block).unsqueeze(-2)
            key = edge.rows_of if edge.rows and self.resolution.by_row else index
            stacks[key] = stacks[key] + stack if key in stacks else stack
        return torch.cat(list(stacks.values()), dim=-2)

    @staticmethod
    def _pull(tapes: LocalGraphs, gradients: Mapping[str, Tensor]) -> tuple[Tensor, ...]:
        """One factor of the chain rule, (∂x/∂source)ᵀ ∇ₓ, for every edge of some quantities x at once (Eq. 1).

        No two tapes share a leaf, so their derivatives do not mix.
        """
        outputs = [tapes[name].output for name in gradients]
        leaves = [leaf for name in gradients for leaf in tapes[name].leaves]
        return torch.autograd.grad(outputs, leaves, list(gradients.values()), retain_graph=True)

    def _resolve(
        self,
        name: str,
        arrived: Sequence[Tensor],
        values: Mapping[str, Tensor],
        before: Mapping[str, Tensor],
        costs: dict[str, Tensor],
    ) -> tuple[list[Tensor], Memory]:
        """Let the resolution decide what leaves a quantity."""
        shape = values[name].shape
        quantity = self.model.quantities[name]
        motion = values[name] if quantity.is_motion else values[name] - before[name]
        gradients = self._stack(quantity, arrived)
        meeting = GradientStack(
            gradients=gradients,
            goals=tuple(arrival.goals for arrival in self.arrivals[name]),
            motion=quantity.flatten(motion),
            costs=costs,
            displaced=lambda goal, shift: self.model.displaced_cost(goal, name, shift.reshape(shape), values),
            dt=self.model.dt,
            final=self.final[name],
            siblings=_beside(gradients, self.siblings[name]),
            before=_beside(gradients, self.before[name]),
        )
        own = {key: before[f"{name}/{key}"] for key in self.remembered[name]}
        resolved, state = self.resolution(meeting, own)
        state = {**state, "gradients": meeting.gradients}
        one_by_one = resolved.unbind(-2) if self.resolution.inherits and not meeting.final else (resolved,)
        leaving = [gradient.reshape(shape) for gradient in one_by_one]
        return leaving, {f"{name}/{key}": value for key, value in state.items()}


def _related(here: Sequence[PartialPath], by: Callable[[int, int], bool]) -> Tensor | None:
    """Which arrivals, i and j, left the same meeting and have ranks so related there; None where none do."""
    origins = [arrival.order or (f"of its own {index}", 0) for index, arrival in enumerate(here)]
    related = torch.tensor([[a == b and by(i, j) for b, j in origins] for a, i in origins])
    return related if related.any() else None


def _beside(gradients: Tensor, related: Tensor | None) -> Tensor | None:
    return None if related is None else related.to(gradients.device)


def _joined(first: tuple[str, ...], second: tuple[str, ...]) -> tuple[str, ...]:
    """The trace of a sum of two gradients: what they have in common from the goal on, then both."""
    if first[:-1] == second[:-1]:
        return (*first[:-1], f"{first[-1]}+{second[-1]}")
    return (f"{' → '.join(first)} + {' → '.join(second)}",)


def _levels(model: WorldModel) -> list[list[str]]:
    """Goals and quantities in the order of the sweep: each level needs only gradients of the levels before it."""
    depth = dict.fromkeys(model.goals, 0)
    names = [*model.goals, *(name for node in reversed(model.nodes) for name in node.outputs if name in model.edges)]
    for name in names:
        for edge in model.edges[name]:
            depth[edge.source] = max(depth.get(edge.source, 0), depth[name] + 1)
    levels: dict[int, list[str]] = {}
    for name in names:
        levels.setdefault(depth[name], []).append(name)
    return [levels[level] for level in sorted(levels)]


def _rounds(level: Iterable[str], leaving: Mapping[str, Sequence[object]]) -> Iterator[dict[str, int]]:
    """Turns in which the gradients that leave a level are pulled back: for each name which of its gradients is next."""
    for turn in range(max(len(leaving[name]) for name in level)):
        yield {name: turn for name in level if turn < len(leaving[name])}
