"""The camera in the hand: where it looks, and how well it sees."""

from dataclasses import dataclass
from typing import cast

import torch
from torch import Tensor, nn

from aicon_torch.parts.chain import tool_frame
from aicon_torch.models.panda_push.robot import Robot

LOOK = {
    "heading": (False, False, True, False, False, True),
    "orientation": (False, False, True, True, True, True),
    "all": (True,) * 6,
}
"""Which components of x_ee serve to look: height and heading, the tilt of the stick as well, or all (the text)."""


class CameraFrame(nn.Module):
    """x_cam: rotation (row by row) and position of the camera, ``(*B, 12)``, m.

    Args:
        robot: The robot.
        look: What serves to look: see :data:`LOOK`.
    """

    def __init__(self, robot: Robot, look: str) -> None:
        super().__init__()
        self.length = robot.stick_length
        self.register_buffer("serves", torch.tensor(LOOK[look]))
        self.register_buffer("mount", torch.tensor(robot.camera, dtype=torch.float64))

    def forward(self, x_ee: Tensor) -> Tensor:
        """The camera where the end effector is."""
        x_ee = torch.where(cast(Tensor, self.serves), x_ee, x_ee.detach())  # the others do not move to see better
        mount = cast(Tensor, self.mount).to(x_ee)
        rotation, origin = tool_frame(x_ee, self.length)
        position = origin + (rotation @ mount[:, 3:]).squeeze(-1)
        return torch.cat(((rotation @ mount[:, :3]).flatten(-2), position), dim=-1)


def split(x_cam: Tensor) -> tuple[Tensor, Tensor]:
    """Rotation ``(*B, 3, 3)`` and position ``(*B, 3)`` of the camera."""
    return x_cam[..., :9].reshape(*x_cam.shape[:-1], 3, 3), x_cam[..., 9:]


def to_world(x_cam: Tensor, points: Tensor) -> Tensor:
    """Points ``(*B, N, 3)`` in the frame of the camera, in that of the base, m."""
    rotation, position = split(x_cam)
    return points @ rotation.mT + position.unsqueeze(-2)


@dataclass(frozen=True)
class Visibility:
    """The variance of what is seen, which grows toward the border of the image and beyond it.

    At (u, v), the image of the object's centre in half widths and half heights from the middle, it is
    σ² (1 + k (u⁴ + v⁴)).

    Attributes:
        robot: The robot.
        scale: px of the contact model per m.
        variances: σ² of x, y (px²) and θ (rad²) in the middle.
        border: k.
        height: Height of the object's centre, m.
    """

    robot: Robot
    scale: float
    variances: tuple[float, float, float]
    border: float
    height: float

    def __call__(self, x_pose: Tensor, x_cam: Tensor) -> Tensor:
        """The variances, ``(*B, 3)``."""
        u, v = self.image(x_pose, x_cam)
        factor = 1 + self.border * (u**4 + v**4)
        return x_cam.new_tensor(self.variances) * factor.clamp(max=1e5).unsqueeze(-1)

    def image(self, x_pose: Tensor, x_cam: Tensor) -> tuple[Tensor, Tensor]:
        """Where the object's centre is in the image, in halves of its size from the middle."""
        focal, _, _, width, height = self.robot.intrinsics
        rotation, position = split(x_cam)
        # Where the object is does not follow the camera, so only the camera's part of the derivative is asked for.
        center = torch.cat((x_pose[..., :2].detach() / self.scale, torch.full_like(x_pose[..., :1], self.height)), -1)
        x, y, z = ((center - position).unsqueeze(-2) @ rotation).squeeze(-2).unbind(-1)
        z = z.clamp(min=0.05)
        return 2 * focal * x / (z * width), 2 * focal * y / (z * height)
