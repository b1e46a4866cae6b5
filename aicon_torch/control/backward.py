"""The backward pass: gradients travel from the goals to the actuators, resolved wherever they meet.

Backpropagation adds up what arrives at a node. Here a resolution decides what goes on instead.
"""

from collections.abc import Mapping, Sequence

import torch
from torch import Tensor

from aicon_torch.control.plan import Plan, Turn
from aicon_torch.differentiation import pull
from aicon_torch.errors import GraphError, OptionError, choices
from aicon_torch.graph import LocalGraphs, WorldModel
from aicon_torch.resolution import GradientStack, Memory, Resolution


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
        plan: The order of the pass.
        paths: For each quantity the path of each gradient of its stack, in this order.
        keys: Keys of what it remembers.

    Raises:
        OptionError: If the resolution names a goal that the model does not have.
        GraphError: If only safety goals depend on an actuator.
    """

    def __init__(self, model: WorldModel, resolution: Resolution) -> None:
        for goal in resolution.goals:
            if goal not in model.goals:
                raise OptionError(
                    f"The resolution names the goal {goal!r}. Goals: {choices(model.goals)}."
                )
        self.model, self.resolution = model, resolution
        self.goals = tuple(name for name, goal in model.goals.items() if not goal.safety)
        self.plan = Plan(model, resolution, self.goals)
        self.paths = self.plan.paths

        # Safety goals bound what an actuator does, and another goal says what.
        for name in model.actuators:
            if name not in self.paths:
                raise GraphError(
                    f"Only safety goals depend on the actuator {name!r}: expected a goal without "
                    "safety=True as well; where another policy proposes what to do, "
                    "Shield(policy, model)."
                )

        # Where gradients are resolved, taken apart by their rows, or pass through as they are.
        self._resolving = frozenset(filter(self._resolves, self.paths))
        self._by_rows = frozenset(filter(self.plan.comes_by_rows, self.paths))
        self._is_last = self._find_last_mergers()

        # What is remembered there.
        self._remembered = {name: tuple(self._initial_at(name)) for name in self._resolving}
        self.keys = tuple(self.initial())

    def resolves_at(self, name: str) -> bool:
        """Whether several gradients arrive at this quantity and are resolved there."""
        return name in self._resolving

    def initial(self) -> Memory:
        """What is remembered of every quantity before the first step, without batch dimensions."""
        memory: Memory = {}
        for name in filter(self.resolves_at, self.paths):
            for key, value in self._initial_at(name).items():
                memory[f"{name}/{key}"] = value
        for name, actuator in self.model.actuators.items():
            memory[f"{name}/gradient"] = torch.zeros(actuator.size)
        return memory

    def recall(self, name: str, memory: Mapping[str, Tensor]) -> Memory:
        """What is remembered of a quantity, by the keys that follow its name and a slash."""
        return {key: memory[f"{name}/{key}"] for key in self._remembered[name]}

    def __call__(
        self,
        graphs: LocalGraphs,
        values: Mapping[str, Tensor],
        memory: Mapping[str, Tensor],
        goal_factors: Tensor,
    ) -> tuple[dict[str, Tensor], Memory]:
        """Travel once from the goals to the actuators.

        Args:
            graphs: The local graphs to travel through.
            values: Values after the step, with the cost of each goal, ``(*B,)``.
            memory: Memory before the step.
            goal_factors: Factor of each goal, ``(*B, goals)``.

        Returns:
            The gradient at each actuator ``(*B, size)``, and the new memory of every quantity.
        """
        arrived: dict[str, list[Tensor]] = {name: [] for name in self.paths}
        new_memory: Memory = {}

        def leaving(name: str) -> list[Tensor]:
            """The gradients that leave a quantity: what they are resolved to, or each by itself."""
            if name in self._resolving:
                # What met is remembered as well, to be explained afterwards.
                stack = self._stack(name, arrived[name], values, memory)
                resolved, remembered = self.resolution(stack, self.recall(name, memory))
                for key, value in (*remembered.items(), ("gradients", stack.gradients)):
                    new_memory[f"{name}/{key}"] = value
                return [resolved.reshape(values[name].shape)]
            if name in self._by_rows:
                return self._row_by_row(name, arrived[name])
            return arrived[name]

        # A goal's own gradient is its factor.
        for goal, factor in zip(self.model.goals, goal_factors.unbind(-1), strict=True):
            if goal in self.goals:
                arrived[goal] = [factor]

        # Level by level: resolve, then pull back along every edge (Eq. 1).
        for level in self.plan.levels:
            gradients = {name: leaving(name) for name in level.names}
            for turn in level.turns:
                pulled = _pull_back(graphs, turn, gradients)
                for edge, gradient in zip(turn.edges, pulled, strict=True):
                    arrived[edge.source].append(gradient)

        # Resolve what arrives at the actuators.
        actions = {name: leaving(name)[0] for name in self.model.actuators}
        for name, gradient in actions.items():
            new_memory[f"{name}/gradient"] = gradient
        return actions, new_memory

    def _resolves(self, name: str) -> bool:
        """Whether several gradients arrive at this quantity, and the rule acts there."""
        acts_here = self.resolution.merges or name in self.model.actuators
        return acts_here and len(self.paths[name]) > 1

    def _find_last_mergers(self) -> dict[str, bool]:
        """For each quantity whether gradients meet nowhere else on the way to the actuators."""
        # From the actuators up: what lies further down is known already.
        is_last = dict.fromkeys(self.model.actuators, True)
        for level in reversed(self.plan.levels):
            for name in level.names:
                sources = [edge.source for edge in self.model.edges[name]]
                is_last[name] = all(
                    is_last[source] and source not in self._resolving for source in sources
                )
        return is_last

    def _initial_at(self, name: str) -> Memory:
        """What is remembered of one quantity: by the resolution, and what arrived there."""
        count, size = len(self.paths[name]), self.model.quantities[name].size
        gradients = torch.zeros(count, size)
        return {**self.resolution.initial(count, size), "gradients": gradients}

    def _row_by_row(self, name: str, arrived: Sequence[Tensor]) -> list[Tensor]:
        """The gradients ``(*B, *shape)`` one by one, those that came row by row taken apart."""
        shape = self.model.quantities[name].shape
        gradients = self._stacked(name, arrived).unbind(-2)
        return [gradient.reshape(*gradient.shape[:-1], *shape) for gradient in gradients]

    def _stack(
        self,
        name: str,
        arrived: Sequence[Tensor],
        values: Mapping[str, Tensor],
        memory: Mapping[str, Tensor],
    ) -> GradientStack:
        """The gradients that meet at a quantity, and what is known there."""
        quantity, value = self.model.quantities[name], values[name]

        # How the quantity moved in the last step: a motion is that itself.
        motion = value if quantity.is_motion else value - memory[name]

        def displaced_cost(goal: str, displacement: Tensor) -> Tensor:
            shift = displacement.reshape(value.shape)
            return self.model.displaced_cost(goal, name, shift, values)

        return GradientStack(
            gradients=self._stacked(name, arrived),
            goals=tuple(path.goals for path in self.paths[name]),
            motion=quantity.flatten(motion),
            costs=values,
            displaced_cost=displaced_cost,
            dt=self.model.dt,
            is_last=self._is_last[name],
        )

    def _stacked(self, name: str, arrived: Sequence[Tensor]) -> Tensor:
        """The gradients that arrived as rows ``(*B, n, d)``; those of one block are summed."""
        quantity = self.model.quantities[name]
        if name not in self._by_rows:
            return torch.stack([quantity.flatten(gradient) for gradient in arrived], dim=-2)

        # Blocks of (*B, rows, d), where a single gradient is a block of one row.
        blocks: dict[int, Tensor] = {}
        for arrival, gradient in zip(self.plan.arrivals[name], arrived, strict=True):
            if not arrival.edge.rows:
                gradient = quantity.flatten(gradient).unsqueeze(-2)

            # What came through the same rows adds up, row by row.
            if arrival.block in blocks:
                gradient = blocks[arrival.block] + gradient
            blocks[arrival.block] = gradient
        return torch.cat(list(blocks.values()), dim=-2)


def _pull_back(
    graphs: LocalGraphs, turn: Turn, gradients: Mapping[str, Sequence[Tensor]]
) -> tuple[Tensor, ...]:
    """(∂x/∂source)ᵀ ∇ₓ for every edge of a turn at once: a factor of Eq. 1 each.

    No two local graphs share a leaf, so their derivatives do not mix.
    """
    # One call of autograd for the whole turn: outputs, their leaves, and the gradients that arrive.
    outputs: list[Tensor] = []
    leaves: list[Tensor] = []
    seeds: list[Tensor] = []
    for name, index in turn.leaving:
        outputs.append(graphs[name].output)
        leaves.extend(graphs[name].leaves)
        seeds.append(gradients[name][index])
    return pull(outputs, leaves, seeds, retain_graph=True)
