"""A force-torque sensor at the wrist: what pushes against the tool, and what follows from it.

Both measurements are implicit: where a force is felt they say that a distance is zero, and
elsewhere nothing.
"""

from dataclasses import dataclass

import torch
from torch import Tensor, nn

from aicon_torch.differentiation import stop
from aicon_torch.parts.contact import nearest_point
from aicon_torch.parts.end_effector import ToolPose
from aicon_torch.parts.planar import norm
from aicon_torch.parts.rigid_object import RigidObject
from aicon_torch.validation import check_positive

GRAVITY = 9.81
"""m/s²"""

UNFELT = 1e-15
"""Least likelihood of a push: a variance that is divided by its square stays finite."""


class ContactForce(nn.Module):
    """x_force: what pushes against the tool, in the frame of the base, ``(*B, 3)``, N.

    The sensor reads what the arm holds the tool with, its weight included. The forces on a tool at
    rest add up to zero, so F = m g − R f with its mass m, its rotation R and the reading f, where g
    points up.

    Args:
        pose: From x_ee to the frame of the tool.
        mass: Mass of all that the sensor carries, kg.
    """

    weight: Tensor

    def __init__(self, pose: ToolPose, mass: float) -> None:
        super().__init__()
        self.pose = pose
        weight = (0.0, 0.0, GRAVITY * mass)
        self.register_buffer("weight", torch.tensor(weight, dtype=torch.float64))

    def forward(self, z_ft: Tensor, x_ee: Tensor) -> Tensor:
        """The force, from the reading ``(*B, 6)`` in the frame of the tool, N and Nm."""
        # The arm does not turn for the sake of a reading.
        rotation, _ = self.pose.to_frame(stop(x_ee))
        force = (rotation @ z_ft[..., :3, None]).squeeze(-1)
        return self.weight.to(z_ft) - force


@dataclass(frozen=True)
class ForceThreshold:
    """How likely a force is a push: p = σ((F − F₀)/w), at least :data:`UNFELT`.

    Attributes:
        force: F₀, at which a push is as likely as not, N; a tool that is accelerated feels less.
        width: w, N.

    Raises:
        OptionError: If the width is not positive.
    """

    force: float
    width: float

    def __post_init__(self) -> None:
        """Check the width."""
        check_positive(self, ("width",))

    def __call__(self, force: Tensor) -> Tensor:
        """p, of the shape of the force, N."""
        return torch.sigmoid((force - self.force) / self.width).clamp(min=UNFELT)


@dataclass(frozen=True)
class TouchedSide:
    """An implicit measurement: where a tool feels a push, its gap to the nearest side is zero.

    Attributes:
        body: The object.
        radius: Radius of the tool, m.
        deviation: Standard deviation σ of the gap under a clear push, m; it is felt at every step.
        push: Which horizontal force is a push.
    """

    body: RigidObject
    radius: float
    deviation: float
    push: ForceThreshold

    def __call__(self, x_pose: Tensor, x_pusher: Tensor) -> Tensor:
        """The gap ``(*B, 1)``, m, between an object at ``(*B, 3)`` and a tool at ``(*B, 2)``."""
        pusher = stop(x_pusher)  # the object's pose is to follow from the touch, not the tool
        _, distance = nearest_point(pusher, self.body.sides(self.body.keypoints_at(x_pose)))
        return distance - self.radius

    def variance(self, x_force: Tensor) -> Tensor:
        """σ²/p² with the likelihood p of a push, ``(*B, 1)``, m²: of no use where there is none."""
        force = stop(x_force[..., :2])  # nothing is pushed in order to feel
        likelihood = self.push(norm(force))
        return (self.deviation / likelihood).square().unsqueeze(-1)


@dataclass(frozen=True)
class TouchedTop:
    """An implicit measurement: where the tool is pushed up, what is below it is as high as its tip.

    Attributes:
        deviation: Standard deviation σ of the height under a clear push, m.
        push: Which force upward is a push.
    """

    deviation: float
    push: ForceThreshold

    def __call__(self, x_top: Tensor, x_ee: Tensor) -> Tensor:
        """Height of the object's top ``(*B, 1)`` above the tip of the tool, ``(*B, 1)``, m."""
        return x_top - stop(x_ee[..., 2:3])  # the height of the top is to follow from the touch

    def variance(self, x_force: Tensor) -> Tensor:
        """σ²/p² with the likelihood p of a push, ``(*B, 1)``, m²."""
        force = stop(x_force[..., 2:3])  # nothing is pushed in order to feel
        return (self.deviation / self.push(force)).square()
