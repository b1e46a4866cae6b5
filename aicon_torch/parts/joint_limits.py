"""The robot's own limits as goals: joints that near their ends, links that near each other."""

from typing import cast

import torch
from torch import Tensor, nn

from aicon_torch.parts.chain import Kinematics
from aicon_torch.models.panda_push.robot import Robot


def nearness(distance: Tensor, margin: float) -> Tensor:
    """max(0, 1 − m/m₀): 0 where the distance m is beyond the margin m₀, 1 where there is none left, more beyond."""
    return (1 - distance / margin).clamp(min=0.0)


class JointLimits(nn.Module):
    """g₃ = p_limit = w Σ max(0, 1 − m/m₀)², where m is a joint's distance to its nearer limit.

    Args:
        robot: The robot.
        margin: m₀, rad: farther from its limits a joint is free.
        weight: w.
    """

    def __init__(self, robot: Robot, margin: float, weight: float) -> None:
        super().__init__()
        self.margin, self.weight = margin, weight
        self.register_buffer("low", torch.tensor(robot.low, dtype=torch.float64))
        self.register_buffer("high", torch.tensor(robot.high, dtype=torch.float64))

    def forward(self, x_joints: Tensor) -> Tensor:
        """The cost ``(*B,)``."""
        low, high = cast(Tensor, self.low).to(x_joints), cast(Tensor, self.high).to(x_joints)
        near = nearness(torch.minimum(x_joints - low, high - x_joints), self.margin)
        return self.weight * (near * near).sum(-1)


class Workspace(nn.Module):
    """w max(0, 1 − m/m₀)², where m is the distance of the tip to the edge of the workspace, a circle about the base.

    There the arm is straight: it cannot go on, and comes back with the elbow bent the other way, toward a stop.

    Args:
        robot: The robot.
        margin: m₀, m.
        weight: w.
    """

    def __init__(self, robot: Robot, margin: float, weight: float) -> None:
        super().__init__()
        self.radius, self.margin, self.weight = robot.reach, margin, weight

    def forward(self, x_ee: Tensor) -> Tensor:
        """The cost ``(*B,)``."""
        radius = torch.sqrt((x_ee[..., :2] * x_ee[..., :2]).sum(-1) + 1e-18)
        near = nearness(self.radius - radius, self.margin)
        return self.weight * near * near


class BodyFrames(nn.Module):
    """x_body: the ends of the robot's capsules, ``(*B, C, 6)``, m.

    Args:
        kinematics: The chain.
        robot: The robot.
    """

    def __init__(self, kinematics: Kinematics, robot: Robot) -> None:
        super().__init__()
        self.kinematics = kinematics
        self.links = [link for link, *_ in robot.capsules]
        ends = [[[*start, 1.0], [*end, 1.0]] for _, start, end, _ in robot.capsules]
        self.register_buffer("ends", torch.tensor(ends, dtype=torch.float64))

    def forward(self, x_joints: Tensor) -> Tensor:
        """The ends in the frame of the base."""
        frames = self.kinematics.frames(x_joints)
        base = torch.eye(4, dtype=frames.dtype, device=frames.device).expand(*frames.shape[:-3], 1, 4, 4)
        frames = torch.cat((base, frames), dim=-3)[..., self.links, :3, :]
        points = cast(Tensor, self.ends).to(frames) @ frames.mT
        return points.flatten(-2)


class SelfCollision(nn.Module):
    """g₄ = p_collision = w Σ max(0, 1 − d/d₀)² over pairs of capsules that can meet, with their distance d.

    Args:
        robot: The robot.
        margin: d₀, m.
        weight: w.
    """

    def __init__(self, robot: Robot, margin: float, weight: float) -> None:
        super().__init__()
        self.margin, self.weight = margin, weight
        links = [link for link, *_ in robot.capsules]
        pairs = [(i, j) for i in range(len(links)) for j in range(i) if abs(links[i] - links[j]) > 2]
        self.first, self.second = [i for i, _ in pairs], [j for _, j in pairs]
        radii = torch.tensor([radius for *_, radius in robot.capsules], dtype=torch.float64)
        self.register_buffer("radii", radii[self.first] + radii[self.second])

    def forward(self, x_body: Tensor) -> Tensor:
        """The cost ``(*B,)``."""
        near = nearness(self.distances(x_body), self.margin)
        return self.weight * (near * near).sum(-1)

    def distances(self, x_body: Tensor) -> Tensor:
        """The gap of each pair, ``(*B, N)``, m."""
        first, second = x_body[..., self.first, :], x_body[..., self.second, :]
        return segment_distance(first, second) - cast(Tensor, self.radii).to(x_body)


def segment_distance(first: Tensor, second: Tensor) -> Tensor:
    """Distance of segments (start, end) ``(*B, 6)``, ``(*B,)``.

    The parameters of the nearest points need no derivative: the distance is stationary there, or they are clamped.
    """
    start, along = first[..., :3], first[..., 3:] - first[..., :3]
    other, beside = second[..., :3], second[..., 3:] - second[..., :3]
    with torch.no_grad():
        offset = start - other
        a, e, f = (along * along).sum(-1), (beside * beside).sum(-1), (beside * offset).sum(-1)
        b, c = (along * beside).sum(-1), (along * offset).sum(-1)
        determinant = (a * e - b * b).clamp(min=1e-12)
        s = ((b * f - c * e) / determinant).clamp(0.0, 1.0)
        t = ((b * s + f) / e.clamp(min=1e-12)).clamp(0.0, 1.0)
        s = ((b * t - c) / a.clamp(min=1e-12)).clamp(0.0, 1.0)
    gap = start + s.unsqueeze(-1) * along - other - t.unsqueeze(-1) * beside
    return torch.sqrt((gap * gap).sum(-1) + 1e-18)
