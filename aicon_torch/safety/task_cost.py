"""What the goals that are followed would cost after a step of an actuator."""

from collections.abc import Mapping

import torch
from torch import Tensor

from aicon_torch.differentiation import hop_from, pull
from aicon_torch.graph import WorldModel
from aicon_torch.interconnections import copied

JUMP = 2.0
"""A cost that grows by more than so many steps at full speed is that of other goals."""


class FollowedCost:
    """G(a) = Σ wᵢ gᵢ one step ahead, over the goals that are no safety goals, with their factors.

    Args:
        model: The world model.
        actuator: Name of the actuator.
        values: Values after the new readings.
        goal_factors: wᵢ, ``(*B, goals)``.
    """

    def __init__(
        self,
        model: WorldModel,
        actuator: str,
        values: Mapping[str, Tensor],
        goal_factors: Tensor,
    ) -> None:
        self.model, self.actuator = model, actuator
        self.values, self.goal_factors = values, goal_factors
        goals = list(enumerate(model.goals.items()))
        self._followed = [(i, name) for i, (name, goal) in goals if not goal.safety]
        self._closing = [(i, name) for i, (name, g) in goals if g.safety and not g.has_room]
        self.at_rest = self.ahead(torch.zeros_like(values[actuator]))

    def ahead(self, action: Tensor) -> Tensor:
        """G(a) ``(*B,)`` of an action ``(*B, n)``, or ``(m, *B)`` of m for each row."""
        return self._total(action, self._followed)

    def not_beyond(self, action: Tensor) -> Tensor:
        """An action ``(*B, n)``, shortened to where the cost is least along it, if that is nearer.

        It is least at s = −b/2c of the way on the parabola G(s) = G(0) + b s + c s² through the
        costs at rest, halfway and in full. Where a goal cannot be reached its slope alone leads
        beyond that, and a stretched arm would go to and fro.
        """
        halfway, full = self.ahead(torch.stack((0.5 * action, action)))
        slope = 4.0 * halfway - full - 3.0 * self.at_rest
        curvature = 2.0 * (full - 2.0 * halfway + self.at_rest)
        is_convex = curvature > 0
        least = -slope / (2.0 * torch.where(is_convex, curvature, 1.0))
        share = torch.where(is_convex, least.clamp(0.0, 1.0), 1.0)
        return share.unsqueeze(-1) * action

    def of_safety(self, action: Tensor) -> Tensor:
        """The same of the safety goals, but for ranges: above 0 where a gap would be closed."""
        return self._total(action, self._closing)

    def slope(self, action: Tensor) -> tuple[Tensor, Tensor]:
        """G(a) and ∂G/∂a, as the model hands it back; 0 where it is not finite."""
        with torch.enable_grad():
            action = hop_from(action).requires_grad_()
            cost = self.ahead(action)
            if not cost.requires_grad:
                return cost, torch.zeros_like(action)
            (gradient,) = pull(cost.sum(), action)
        return hop_from(cost), torch.where(gradient.isfinite(), gradient, 0.0)

    def steepness(self, steps: Tensor) -> Tensor:
        """‖∂G/∂a‖ by differences, ``(*B,)``: by how much it falls along its steepest descent.

        It is the true gradient, whatever an estimator makes of the gradients that go through it.

        Args:
            steps: By how much each component is varied, ``(n,)``.
        """
        own_dimensions = [1] * self.at_rest.dim()
        alone = torch.diag(steps).reshape(len(steps), *own_dimensions, len(steps))
        actions = alone.expand(len(steps), *self.values[self.actuator].shape)

        change = self.ahead(actions) - self.at_rest
        slopes = change / steps.reshape(-1, *own_dimensions)
        steepness: Tensor = torch.linalg.vector_norm(slopes, dim=0)
        return steepness

    def _total(self, action: Tensor, goals: list[tuple[int, str]]) -> Tensor:
        """Σ wᵢ gᵢ of some goals, ``(*B,)`` or ``(m, *B)``."""
        copies = action.shape[: action.dim() - self.goal_factors.dim()]
        values = copied(self.values, *copies)
        total = torch.zeros_like(action[..., 0])
        for index, name in goals:
            cost = self.model.displaced_cost(name, self.actuator, action, values)
            total = total + self.goal_factors[..., index] * cost
        return total


def is_of_other_goals(cost: FollowedCost, before: Tensor, limits: Tensor, least: float) -> Tensor:
    """Whether the goals are other ones, ``(*B,)``: no step can raise a cost by so much.

    Args:
        cost: What they cost now.
        before: What was the cost one step ago, ``(*B,)``.
        limits: Of the actuator, ``(n,)``.
        least: By no less than this share.
    """
    limits = limits.to(cost.at_rest)
    by_motion = JUMP * cost.steepness(limits) * torch.linalg.vector_norm(limits)
    return cost.at_rest > before + torch.maximum(by_motion, least * before)
