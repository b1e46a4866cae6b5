"""Where the object is: predicted from what the pusher did, corrected by the registration of its keypoints."""

import math
from dataclasses import dataclass

import torch
from torch import Tensor

from aicon_torch.parts.contact import closest_point, norm
from aicon_torch.parts.contact_dynamics import ContactDynamics
from aicon_torch.parts.rigid_object import Outline
from aicon_torch.parts.servo import RADIUS
from aicon_torch.vectors import select


@dataclass(frozen=True)
class PoseMotion:
    """The object's pose after the last action: pushed as far as the pusher went beyond the nearest side.

    Attributes:
        dynamics: What a push does.
        radius: Radius of the pusher, px.
    """

    dynamics: ContactDynamics
    radius: float = RADIUS

    def __call__(self, x_pose: Tensor, x_pusher: Tensor, a: Tensor, dt: float) -> Tensor:
        """The pose (x, y, θ) ``(*B, 3)``.

        Args:
            x_pose: The pose before, ``(*B, 3)``.
            x_pusher: Where the pusher has arrived, ``(*B, 2)``, px.
            a: With which mean velocity, ``(*B, 2)``, px/s.
            dt: In what time, s.
        """
        motion = a.detach() * dt  # what moved the object is past; what will move it is the contact model's matter
        before = (x_pusher.detach() - motion).unsqueeze(-2)
        pose = x_pose.detach()  # how a push depends on the pose is of second order: the belief moves as it is
        points = closest_point(before, self.dynamics.outline.sides(self.dynamics.outline.placed(pose)))
        distance = norm(points - before)
        nearest = distance.argmin(-1, keepdim=True)
        point, gap = select(points, nearest), distance.gather(-1, nearest).squeeze(-1) - self.radius
        normal = (point - before.squeeze(-2)) / (gap + self.radius).unsqueeze(-1)
        push = ((motion * normal).sum(-1) - gap.clamp(min=0.0)).clamp(min=0.0)
        response = self.dynamics.response(pose, point.unsqueeze(-2), normal.unsqueeze(-2)).squeeze(-2)
        return x_pose + push.unsqueeze(-1) * response


def rest(x_pose: Tensor) -> Tensor:
    """The pose where it was last seen."""
    return x_pose


def same(z_keypoints: Tensor) -> Tensor:
    """The identity ``(3, 3)``: the derivative of the pose's prediction and of its residual by the pose.

    Any quantity will do as argument: it tells dtype and device.
    """
    return torch.eye(3, dtype=z_keypoints.dtype, device=z_keypoints.device)


@dataclass(frozen=True)
class Registration:
    """The residual x_pose − pose(z_keypoints), with the angle in [−π, π), ``(*B, 3)``, px and rad.

    Attributes:
        outline: Whose keypoints they are.
    """

    outline: Outline

    def __call__(self, x_pose: Tensor, z_keypoints: Tensor) -> Tensor:
        """The residual."""
        residual = x_pose - self.seen(z_keypoints)
        angle = torch.remainder(residual[..., 2:] + math.pi, 2 * math.pi) - math.pi
        return torch.cat((residual[..., :2], angle), dim=-1)

    def seen(self, z_keypoints: Tensor) -> Tensor:
        """The pose that a reading ``(*B, 2N)`` shows, ``(*B, 3)``."""
        return self.outline.pose(z_keypoints.reshape(*z_keypoints.shape[:-1], -1, 2))

    def prior(self, z_keypoints: Tensor) -> tuple[Tensor, Tensor]:
        """The pose at first: where the first reading shows it, give or take 10 px."""
        spread = z_keypoints.new_tensor((10.0, 10.0, 10.0 / self.outline.gyration))
        return self.seen(z_keypoints), torch.diag(spread**2)

    def variances(self, noise: float) -> tuple[float, float, float]:
        """Variances of a registered pose (px², px², rad²) for keypoints with a standard deviation (px)."""
        middle = self.outline.keypoints.mean(0)  # where the position is known best
        spread = self.outline.keypoints - middle
        turn = noise**2 / float((spread * spread).sum())
        x, y = (noise**2 / len(spread) + turn * middle.flip(0) ** 2).tolist()
        return x, y, turn
