"""What the wrist feels: force without the weight of the tool, and what it says of contact and height."""

from dataclasses import dataclass
from typing import cast

import torch
from torch import Tensor, nn

from aicon_torch.parts.chain import tool_frame
from aicon_torch.parts.contact import closest_point, norm
from aicon_torch.parts.rigid_object import Outline
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
        certainty: Standard deviation σ of the gap under a clear push, px; it is felt at every step.
        threshold: Force at which a push is as likely as not, N: a tool that is accelerated feels less.
        width: By how much more it becomes likely, N.
    """

    outline: Outline
    radius: float
    certainty: float = 10.0
    threshold: float = 1.2
    width: float = 0.1

    def __call__(self, x_pose: Tensor, x_pusher: Tensor) -> Tensor:
        """The gap, ``(*B, 1)``, px."""
        pusher = x_pusher.detach().unsqueeze(-2)  # the object's pose is to follow from the touch, not the pusher
        points = closest_point(pusher, self.outline.sides(self.outline.placed(x_pose)))
        distance = norm(points - pusher)
        nearest = distance.argmin(-1, keepdim=True)
        return norm(select(points, nearest) - pusher.squeeze(-2)).unsqueeze(-1) - self.radius

    def variance(self, x_force: Tensor) -> Tensor:
        """Its variance σ²/p² with the likelihood p of a push, ``(*B, 1)``, px²: beyond use without one."""
        push = torch.sigmoid((norm(x_force.detach()[..., :2]) - self.threshold) / self.width)
        return (self.certainty / push).square().unsqueeze(-1)


@dataclass(frozen=True)
class Resting:
    """An implicit interconnection: where the stick is pushed up, what is below it is as high as its tip.

    Attributes:
        threshold: Force at which this is as likely as not, N.
        width: By how much more it becomes likely, N.
    """

    threshold: float = 2.0
    width: float = 0.15

    def __call__(self, x_top: Tensor, x_ee: Tensor) -> Tensor:
        """Height of the top above the tip, ``(*B, 1)``, m."""
        return x_top - x_ee[..., 2:3].detach()  # the height of the top is to follow from the touch

    def variance(self, x_force: Tensor) -> Tensor:
        """Its variance, ``(*B, 1)``, m²."""
        push = torch.sigmoid((x_force[..., 2:3].detach() - self.threshold) / self.width)
        return 1e-5 / push.square()
