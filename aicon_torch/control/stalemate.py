"""Stalemates: where constraints bring an actuator to rest short of its goals, and the way out."""

from collections.abc import Mapping

import torch
from torch import Tensor

from aicon_torch.graph import WorldModel
from aicon_torch.resolution import Memory
from aicon_torch.safety import ConstraintEscape, SafeAction, SafetyBounds
from aicon_torch.vectors import unit


class Stalemate:
    """Detects that constraints hold up the goals, and moves along the constraints' force.

    See :class:`aicon_torch.safety.ConstraintEscape`.

    Args:
        model: The world model.
        actuator: Name of the actuator.
        options: When an escape begins and ends.
        time: T, the time constant of the dampers, s.
    """

    def __init__(
        self, model: WorldModel, actuator: str, options: ConstraintEscape, time: float
    ) -> None:
        self.model, self.actuator, self.options = model, actuator, options
        self.tick = model.dt / time
        self.followed = [name for name, goal in model.goals.items() if not goal.safety]

    def initial(self) -> Memory:
        """Not escaping; nothing was reached yet. Without batch dimensions."""
        size = self.model.actuators[self.actuator].size
        return {
            "escaping": torch.tensor(False),
            "clock": torch.tensor(0.0),
            "lowest": torch.tensor(torch.inf),
            "best": torch.tensor(torch.inf),
            "tries": torch.tensor(0),
            "detour": torch.tensor(False),
            "direction": torch.zeros(size),
        }

    def aim(self, wish: Tensor, limits: Tensor, memory: Memory) -> Tensor:
        """What the actuator tries: the wish, or at full speed what leads out, ``(*B, n)``.

        Args:
            wish: What the goals wish for, ``(*B, n)``.
            limits: Of the actuator, ``(n,)``.
            memory: What was remembered.
        """
        direction = memory["direction"]
        excess = (direction.abs() / limits).amax(-1, keepdim=True)
        fastest = direction / excess.clamp(min=torch.finfo(wish.dtype).tiny ** 0.5)
        return torch.where(memory["escaping"].unsqueeze(-1), fastest, wish)

    def judge(
        self,
        values: Mapping[str, Tensor],
        wish: Tensor,
        safe: SafeAction,
        within: SafetyBounds,
        limits: Tensor,
        memory: Memory,
        goal_factors: Tensor,
    ) -> Memory:
        """Whether to escape from the next step on, and where to.

        Args:
            values: Values after the new readings.
            wish: What the goals wish for, ``(*B, n)``.
            safe: What the constraints made of what was tried.
            within: The constraints.
            limits: Of the actuator, ``(n,)``.
            memory: What was remembered.
            goal_factors: Factor of each goal, ``(*B, goals)``.
        """
        options, escaping = self.options, memory["escaping"]
        cost = self._cost_ahead(values, torch.zeros_like(wish), goal_factors)
        clock = memory["clock"] + self.tick

        # Does it stand still? The cost has not fallen for long, though there is far to go.
        has_fallen = cost < (1.0 - options.progress) * memory["lowest"]
        enters = ~has_fallen & (clock >= options.patience) & (cost > options.near)

        # Is it over the crest? The cost falls along the motion, not only a little.
        falls = self._fall(values, safe.action, cost, goal_factors)
        steepness = self._steepness(values, limits, cost, goal_factors)
        over = falls > options.crest * steepness
        blocked = (safe.action.abs() / limits).amax(-1) < options.blocked
        ends = (clock >= options.shortest) & (over | blocked) | (clock >= options.longest)
        leaves = torch.where(memory["detour"], clock >= options.detour, ends)

        # The clock begins anew with every progress, escape and attempt.
        changes = torch.where(escaping, leaves, enters)
        progresses = ~escaping & has_fallen
        begins = ~escaping & enters

        # Every escape without a new best is one more try.
        is_best = ~escaping & (cost < (1.0 - options.progress) * memory["best"])
        tries = torch.where(is_best, 0, memory["tries"] + begins)
        opposed = (safe.force * wish).sum(-1) < -0.1 * (wish * wish).sum(-1)
        detours = ~opposed | (memory["tries"] >= options.forced)
        way_out = torch.where(
            detours.unsqueeze(-1), _spread(memory["tries"], wish), unit(safe.force)
        )
        return {
            "escaping": escaping ^ changes,
            "clock": torch.where(changes | progresses, 0.0, clock),
            "lowest": torch.where(changes | progresses, cost, memory["lowest"]),
            "best": torch.where(is_best, cost, memory["best"]),
            "tries": tries,
            "detour": torch.where(begins, detours, memory["detour"]),
            "direction": torch.where(begins.unsqueeze(-1), way_out, memory["direction"]),
        }

    def _fall(
        self, values: Mapping[str, Tensor], action: Tensor, cost: Tensor, goal_factors: Tensor
    ) -> Tensor:
        """By how much the goals' cost falls along an action of length one, ``(*B,)``."""
        length = torch.linalg.vector_norm(action, dim=-1)
        smallest = torch.finfo(length.dtype).tiny ** 0.5
        return (cost - self._cost_ahead(values, action, goal_factors)) / length.clamp(min=smallest)

    def _steepness(
        self, values: Mapping[str, Tensor], limits: Tensor, cost: Tensor, goal_factors: Tensor
    ) -> Tensor:
        """By how much it falls along its steepest descent, ``(*B,)``: from each component alone."""
        count = len(limits)
        copies = {name: value.expand(count, *value.shape) for name, value in values.items()}
        alone = torch.diag(limits).reshape(count, *[1] * cost.dim(), count)
        actions = alone.expand_as(copies[self.actuator])

        change = self._cost_ahead(copies, actions, goal_factors) - cost
        slopes = change / limits.reshape(count, *[1] * cost.dim())
        return torch.linalg.vector_norm(slopes, dim=0)

    def _cost_ahead(
        self, values: Mapping[str, Tensor], action: Tensor, goal_factors: Tensor
    ) -> Tensor:
        """What the goals that are followed cost after a step of this action, ``(*B,)``."""
        total = torch.zeros_like(action[..., 0])
        for index, name in enumerate(self.model.goals):
            if name in self.followed:
                cost = self.model.displaced_cost(name, self.actuator, action, values)
                total = total + goal_factors[..., index] * cost
        return total


def _spread(index: Tensor, like: Tensor) -> Tensor:
    """Direction number i of a sequence that covers all directions evenly, ``(*B, n)``.

    Component j is the i-th number of an additive recurrence with the step φ⁻ʲ⁻¹, where φ is the
    positive root of xⁿ⁺¹ = x + 1 (Roberts 2018), spread over [−1, 1].
    """
    size = like.shape[-1]
    root = 2.0
    for _ in range(50):
        root = (1.0 + root) ** (1.0 / (size + 1))
    steps = like.new_tensor([root ** -(component + 1) for component in range(size)])
    return 2.0 * torch.remainder(0.5 + (index.unsqueeze(-1) + 1) * steps, 1.0) - 1.0
