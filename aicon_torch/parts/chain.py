"""Kinematics: from joint angles to the end effector and the links, and how a gradient goes back.

Not those of pytorch-kinematics: its URDF loader rounds to float32 (2.4e-8 m), and a chain built from numbers is as long
as the product here, makes a step a tenth slower and needs four more packages. docs/arm.md has the figures.
"""

from typing import Any, cast

import torch
from torch import Tensor, nn

from aicon_torch.models.panda_push.robot import Robot

LEVER = 0.2
"""A turn of one rad counts as much as a motion of this, m; so all components of x_ee are lengths."""

EE_SIZE = 6
"""Components of x_ee: position of the tip (x, y, z), the stick's axis (x, y), and the heading of the camera, m."""


class Kinematics(nn.Module):
    """The serial chain: after each fixed transform the link turns about its z axis.

    Local transforms are affine in (cos q, sin q), so all seven are built at once.

    Args:
        robot: The robot.
        damping: λ of the damped pseudo-inverse, m/rad.
    """

    def __init__(self, robot: Robot, damping: float = 0.02) -> None:
        super().__init__()
        fixed = torch.eye(4, dtype=torch.float64).repeat(8, 1, 1)
        fixed[:7, :3] = torch.tensor(robot.frames, dtype=torch.float64)
        fixed[7, :3] = torch.tensor(robot.tool, dtype=torch.float64)
        x, y, z, w = (fixed[:7] @ _unit(axis) for axis in range(4))
        zero = torch.zeros_like(x)
        self.register_buffer("constant", torch.cat((zero, zero, z, w), dim=-1))
        self.register_buffer("by_cos", torch.cat((x, y, zero, zero), dim=-1))
        self.register_buffer("by_sin", torch.cat((y, -x, zero, zero), dim=-1))
        self.register_buffer("tool", fixed[7])
        self.length, self.damping = robot.stick_length, damping

    def frames(self, x_joints: Tensor) -> Tensor:
        """Transforms of the seven links and the tool, ``(*B, 8, 4, 4)``, m."""
        constant, by_cos, by_sin = (
            cast(Tensor, part).to(x_joints) for part in (self.constant, self.by_cos, self.by_sin)
        )
        cos, sin = torch.cos(x_joints)[..., None, None], torch.sin(x_joints)[..., None, None]
        local = constant + cos * by_cos + sin * by_sin
        frame = local[..., 0, :, :]
        frames = [frame]
        for index in range(1, 7):
            frame = frame @ local[..., index, :, :]
            frames.append(frame)
        frames.append(frame @ cast(Tensor, self.tool).to(frame))
        return torch.stack(frames, dim=-3)

    def end_effector(self, frames: Tensor) -> Tensor:
        """x_ee ``(*B, 6)`` from the frames."""
        tool = frames[..., 7, :, :]
        tip = tool[..., :3, 3] + self.length * tool[..., :3, 2]
        heading = torch.atan2(tool[..., 1, 0], tool[..., 0, 0])
        return torch.cat((tip, LEVER * tool[..., :2, 2], LEVER * heading.unsqueeze(-1)), dim=-1)

    def jacobian(self, frames: Tensor) -> Tensor:
        """∂x_ee/∂q ``(*B, 6, 7)``: joint i turns everything after it about its z axis."""
        axes, origins = frames[..., :7, :3, 2], frames[..., :7, :3, 3]
        tool = frames[..., 7, :, :]
        stick, heading = tool[..., :3, 2], tool[..., :3, 0]
        tip = tool[..., :3, 3] + self.length * stick
        moves = torch.linalg.cross(axes, tip.unsqueeze(-2) - origins)
        tilts = torch.linalg.cross(axes, stick.unsqueeze(-2).expand_as(axes))[..., :2]
        turns = torch.linalg.cross(axes, heading.unsqueeze(-2).expand_as(axes))
        x, y = heading[..., 0, None], heading[..., 1, None]
        yaw = (x * turns[..., 1] - y * turns[..., 0]) / (x * x + y * y)
        return torch.cat((moves, LEVER * tilts, LEVER * yaw.unsqueeze(-1)), dim=-1).mT

    def solve(self, jacobian: Tensor, wish: Tensor) -> Tensor:
        """J⁺w = Jᵀ(JJᵀ + λ²I)⁻¹ w: the joint motion ``(*B, 7)`` that moves x_ee by w ``(*B, 6)``."""
        square = jacobian @ jacobian.mT
        square = square + self.damping**2 * torch.eye(EE_SIZE, dtype=square.dtype, device=square.device)
        motion: Tensor = (jacobian.mT @ torch.linalg.solve_ex(square, wish.unsqueeze(-1)).result).squeeze(-1)
        return motion

    def natural(self, jacobian: Tensor, gradient: Tensor) -> Tensor:
        """The joint gradient ``(*B, 7)`` along J⁺h for a gradient h of x_ee ``(*B, 6)``.

        Its length is that of a gradient in that direction, the change of the cost per rad, hᵀJJ⁺h / ‖J⁺h‖. That of J⁺h
        would say how far the joints must go, and near a singularity outgrow all gradients that it meets.
        """
        motion = self.solve(jacobian, gradient)
        change = (gradient * (jacobian @ motion.unsqueeze(-1)).squeeze(-1)).sum(-1, keepdim=True)
        square = (motion * motion).sum(-1, keepdim=True).clamp(min=torch.finfo(motion.dtype).tiny)
        return motion * (change / square)


class EndEffector(nn.Module):
    """x_ee, and which joint gradient stands for a gradient of x_ee.

    A gradient h says where x_ee is to go. ``"natural"`` asks for the joints that take it there, along J⁺h: the steepest
    descent in the metric of the table, see :meth:`Kinematics.natural`. ``"transpose"`` is the chain rule to the letter,
    Jᵀh, the steepest descent in that of the joints, whose motion of the tip points up to 40° away from h.

    Args:
        kinematics: The chain.
        pullback: Which of them.
    """

    def __init__(self, kinematics: Kinematics, pullback: str = "natural") -> None:
        super().__init__()
        self.kinematics, self.pullback = kinematics, pullback

    def forward(self, x_joints: Tensor) -> Tensor:
        """x_ee ``(*B, 6)``: position of the tip, and tilt and heading as lengths, m."""
        if self.pullback == "transpose" or not x_joints.requires_grad:
            return self.kinematics.end_effector(self.kinematics.frames(x_joints))
        return cast(Tensor, _Natural.apply(x_joints, self.kinematics))  # type: ignore[no-untyped-call]  # torch leaves apply untyped


class _Natural(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, x_joints: Tensor, kinematics: Kinematics) -> Tensor:
        frames = kinematics.frames(x_joints)
        ctx.kinematics = kinematics
        ctx.save_for_backward(frames)
        return kinematics.end_effector(frames)

    @staticmethod
    def backward(ctx: Any, *gradients: Any) -> tuple[Tensor, None]:
        (frames,) = ctx.saved_tensors
        return ctx.kinematics.natural(ctx.kinematics.jacobian(frames), gradients[0]), None


def tool_frame(x_ee: Tensor, length: float) -> tuple[Tensor, Tensor]:
    """Rotation ``(*B, 3, 3)`` and origin ``(*B, 3)`` of the tool from x_ee: the inverse of its definition."""
    tilt, heading = x_ee[..., 3:5] / LEVER, x_ee[..., 5] / LEVER
    down = -torch.sqrt((1 - (tilt * tilt).sum(-1, keepdim=True)).clamp(min=0.05))
    stick = torch.cat((tilt, down), dim=-1)
    level = torch.stack((torch.cos(heading), torch.sin(heading)), dim=-1)
    rise = -(tilt * level).sum(-1, keepdim=True) / down
    ahead = torch.cat((level, rise), dim=-1)
    ahead = ahead / torch.linalg.vector_norm(ahead, dim=-1, keepdim=True)
    rotation = torch.stack((ahead, torch.linalg.cross(stick, ahead), stick), dim=-1)
    return rotation, x_ee[..., :3] - length * stick


def _unit(axis: int) -> Tensor:
    return torch.eye(4, dtype=torch.float64)[:, axis : axis + 1]
