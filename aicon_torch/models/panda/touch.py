"""What the wrist feels: force without the weight of the tool, and what it says of contact and height."""

from dataclasses import dataclass
from typing import cast

import torch
from torch import Tensor, nn

from aicon_torch.models.panda.kinematics import tool_frame
from aicon_torch.models.pusht.contacts import closest_point, norm
from aicon_torch.models.pusht.outline import Outline
from aicon_torch.vectors import select


class Felt(nn.Module):
    """x_force: what pushes against the tool, ``(*B, 3)``, N, in the frame of the base.

    The sensor reads what the arm holds the tool with, its weight included; F = m g − R f balances it.

    Args:
        mass: Of the tool, kg.
        length: Of the stick, m.
    """

    def __init__(self, mass: float, length: float) -> None:
        super().__init__()
        self.length = length
        self.register_buffer("weight", torch.tensor((0.0, 0.0, 9.81 * mass), dtype=torch.float64))

    def forward(self, z_ft: Tensor, x_ee: Tensor) -> Tensor:
        """The force; the reading leads no gradient anywhere."""
        rotation, _ = tool_frame(x_ee.detach(), self.length)
        return cast(Tensor, self.weight).to(z_ft) - (rotation @ z_ft[..., :3, None]).squeeze(-1)


@dataclass(frozen=True)
class Touching:
    """An implicit interconnection: where the stick feels a push, the gap to the nearest side is zero.

    Attributes:
        outline: The object.
        radius: Of the stick, px.
        certainty: Standard deviation of the gap under a clear push, px.
        threshold: Force by which a push becomes clear, N.
    """

    outline: Outline
    radius: float
    certainty: float = 2.0
    threshold: float = 0.7

    def __call__(self, x_pose: Tensor, x_pusher: Tensor) -> Tensor:
        """The gap, ``(*B, 1)``, px."""
        pusher = x_pusher.detach().unsqueeze(-2)  # the object's pose is to follow from the touch, not the pusher
        points = closest_point(pusher, self.outline.sides(self.outline.placed(x_pose)))
        distance = norm(points - pusher)
        nearest = distance.argmin(-1, keepdim=True)
        return norm(select(points, nearest) - pusher.squeeze(-2)).unsqueeze(-1) - self.radius

    def variance(self, x_force: Tensor) -> Tensor:
        """Its variance, ``(*B, 1)``, px²: beyond use without a push."""
        push = norm(x_force.detach()[..., :2]) / self.threshold
        return (self.certainty**2 + 1e6 * torch.exp(-push * push)).unsqueeze(-1)


@dataclass(frozen=True)
class Resting:
    """An implicit interconnection: where the stick is pushed up, what is below it is as high as its tip.

    Attributes:
        threshold: Force by which this becomes clear, N.
    """

    threshold: float = 2.0

    def __call__(self, x_top: Tensor, x_ee: Tensor) -> Tensor:
        """Height of the top above the tip, ``(*B, 1)``, m."""
        return x_top - x_ee[..., 2:3].detach()  # the height of the top is to follow from the touch

    def variance(self, x_force: Tensor) -> Tensor:
        """Its variance, ``(*B, 1)``, m²."""
        push = x_force[..., 2:3].detach().clamp(min=0.0) / self.threshold
        return 1e-5 + 1e2 * torch.exp(-push * push)
