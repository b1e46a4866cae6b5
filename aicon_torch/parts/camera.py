"""A camera in the hand: where it is, and how well it sees an object."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, NamedTuple

import torch
from torch import Tensor, nn

from aicon_torch.differentiation import stop
from aicon_torch.parts.end_effector import ToolPose
from aicon_torch.parts.joint_product import Transform
from aicon_torch.validation import check_choice

Steering = Literal["heading", "orientation", "all"]

STEERED_COMPONENTS: Mapping[Steering, tuple[bool, ...]] = {
    "heading": (False, False, True, False, False, True),
    "orientation": (False, False, True, True, True, True),
    "all": (True, True, True, True, True, True),
}
"""Components of x_ee that move in order to see better: height and heading, the tilt too, or all."""


LARGEST_GROWTH = 1e5
"""Of a variance toward the edge of the image, so that it stays a number far outside."""

NEAREST = 0.05
"""Least depth that an object is taken to have, m: behind the camera it is far off the image."""


class Intrinsics(NamedTuple):
    """A pinhole camera without distortion.

    Attributes:
        focal: Focal length, px.
        center_x: Column of the optical axis, px.
        center_y: Row of the optical axis, px.
        width: Columns of the image, px.
        height: Rows of the image, px.
    """

    focal: float
    center_x: float
    center_y: float
    width: float
    height: float


class CameraFrame(nn.Module):
    """x_cam: rotation (row by row) and position of a camera fixed to the tool, ``(*B, 12)``, m.

    Args:
        pose: From x_ee to the frame of the tool.
        mount: The camera in the tool: z into the image, x to its right, y down.
        steering: What moves in order to see better: see :data:`STEERED_COMPONENTS`. The paper's
            text leaves it to all components.

    Raises:
        OptionError: If there is no such steering.
    """

    steered: Tensor
    mount: Tensor

    def __init__(self, pose: ToolPose, mount: Transform, steering: Steering = "all") -> None:
        super().__init__()
        self.pose, self.steering = pose, steering
        check_choice(self, "steering", tuple(STEERED_COMPONENTS))
        self.register_buffer("steered", torch.tensor(STEERED_COMPONENTS[steering]))
        self.register_buffer("mount", torch.tensor(mount, dtype=torch.float64))

    def forward(self, x_ee: Tensor) -> Tensor:
        """x_cam ``(*B, 12)`` where the end effector is, ``(*B, 6)``, m."""
        # No gradient reaches the other components: they do not move in order to see better.
        x_ee = torch.where(self.steered, x_ee, stop(x_ee))
        rotation, origin = self.pose.to_frame(x_ee)

        # The camera in the frame of the tool, and so in that of the base.
        mount_rotation, mount_position = torch.split(self.mount.to(x_ee), [3, 1], dim=-1)
        position = origin + (rotation @ mount_position).squeeze(-1)
        return torch.cat(((rotation @ mount_rotation).flatten(-2), position), dim=-1)


def split_frame(x_cam: Tensor) -> tuple[Tensor, Tensor]:
    """Rotation ``(*B, 3, 3)`` and position ``(*B, 3)`` of a camera x_cam ``(*B, 12)``."""
    return x_cam[..., :9].reshape(*x_cam.shape[:-1], 3, 3), x_cam[..., 9:]


def to_world(x_cam: Tensor, points: Tensor) -> Tensor:
    """Points in the frame of the camera, ``(*B, N, 3)``, in that of the base, m."""
    rotation, position = split_frame(x_cam)
    return points @ rotation.mT + position.unsqueeze(-2)


@dataclass(frozen=True)
class Visibility:
    """The variance of what is seen, which grows toward the edge of the image and beyond it.

    Where the image of the object's centre is at (u, v), in half widths and half heights from the
    middle, it is σ² (1 + k (u⁴ + v⁴)).

    Attributes:
        intrinsics: Of the camera.
        variances: σ² of x, y (m²) and θ (rad²) in the middle of the image.
        edge_growth: k.
        height: Height of the object's centre, m.
    """

    intrinsics: Intrinsics
    variances: tuple[float, float, float]
    edge_growth: float
    height: float

    def __call__(self, x_pose: Tensor, x_cam: Tensor) -> Tensor:
        """The variances ``(*B, 3)`` of a pose ``(*B, 3)``, seen by a camera ``(*B, 12)``."""
        u, v = self.image_point(x_pose, x_cam)
        factor = 1 + self.edge_growth * (u**4 + v**4)
        variances = x_cam.new_tensor(self.variances)
        return variances * factor.clamp(max=LARGEST_GROWTH).unsqueeze(-1)

    def image_point(self, x_pose: Tensor, x_cam: Tensor) -> tuple[Tensor, Tensor]:
        """(u, v): where the image of the object's centre is, ``(*B,)`` each."""
        # The object does not follow the camera, so only the camera's part of the derivative counts.
        height = torch.zeros_like(x_pose[..., :1]) + self.height
        center = torch.cat((stop(x_pose[..., :2]), height), dim=-1)

        # In the camera's frame, z ahead. A row times R is Rᵀ times the column.
        rotation, position = split_frame(x_cam)
        seen = ((center - position).unsqueeze(-2) @ rotation).squeeze(-2)
        x, y, z = seen.unbind(-1)
        z = z.clamp(min=NEAREST)

        # f x/z is in px from the axis; in half widths it is 1 at the edge.
        focal, width = self.intrinsics.focal, self.intrinsics.width
        return 2 * focal * x / (z * width), 2 * focal * y / (z * self.intrinsics.height)
