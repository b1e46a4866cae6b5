"""Collisions of the robot with itself as a goal: capsules on its links, and their distances."""

from collections.abc import Sequence
from typing import NamedTuple, cast

import torch
from torch import Tensor, nn

from aicon_torch.parts.chain import Chain
from aicon_torch.parts.hinge import SquaredHinge

Point = tuple[float, float, float]

FREE_LINKS = 2
"""Links that are at most so far apart in the chain are not compared: their joint limits keep them apart."""


class Capsule(NamedTuple):
    """A segment with a radius, fixed to a link.

    Attributes:
        link: 0 for the base, i for the link after joint i, n + 1 for the tool.
        start: One end of the segment in the frame of the link, m.
        end: The other end, m.
        radius: m.
    """

    link: int
    start: Point
    end: Point
    radius: float


class CapsuleSegments(nn.Module):
    """x_body: the segments (start, end) of a robot's capsules in the frame of the base.

    Args:
        chain: From the joints to the links.
        capsules: The shape of the robot.
    """

    def __init__(self, chain: Chain, capsules: Sequence[Capsule]) -> None:
        super().__init__()
        self.chain = chain
        self.links = [capsule.link for capsule in capsules]
        ends = [[[*capsule.start, 1.0], [*capsule.end, 1.0]] for capsule in capsules]
        self.register_buffer("ends", torch.tensor(ends, dtype=torch.float64))

    def forward(self, x_joints: Tensor) -> Tensor:
        """The C segments ``(*B, C, 6)``, m, at the joint angles ``(*B, n)``, rad."""
        frames = self.chain.frames(x_joints)
        base = torch.eye(4, dtype=frames.dtype, device=frames.device)
        base = base.expand(*frames.shape[:-3], 1, 4, 4)

        transforms = torch.cat((base, frames), dim=-3)[..., self.links, :3, :]
        ends = cast(Tensor, self.ends).to(frames) @ transforms.mT
        return ends.flatten(-2)


class SelfCollision(nn.Module):
    """g = w Σ max(0, 1 − d/d₀)² over the pairs of capsules that can meet, d being their distance.

    The paper's g₄ = p_collision(x_body).

    Args:
        capsules: The shape of the robot.
        cost: Margin d₀ (m) and weight w.
    """

    def __init__(self, capsules: Sequence[Capsule], cost: SquaredHinge) -> None:
        super().__init__()
        self.cost = cost
        self.first: list[int] = []
        self.second: list[int] = []

        for i, capsule in enumerate(capsules):
            for j, other in enumerate(capsules[:i]):
                if abs(capsule.link - other.link) > FREE_LINKS:
                    self.first.append(i)
                    self.second.append(j)

        radii = torch.tensor([capsule.radius for capsule in capsules], dtype=torch.float64)
        self.register_buffer("radii", radii[self.first] + radii[self.second])

    def forward(self, x_body: Tensor) -> Tensor:
        """The cost ``(*B,)`` of the segments ``(*B, C, 6)``, m."""
        return self.cost(self.distances(x_body))

    def distances(self, x_body: Tensor) -> Tensor:
        """The distance of each pair of capsules, ``(*B, pairs)``, m; negative where they overlap."""
        first, second = x_body[..., self.first, :], x_body[..., self.second, :]
        return segment_distance(first, second) - cast(Tensor, self.radii).to(x_body)


def segment_distance(first: Tensor, second: Tensor) -> Tensor:
    """The distance ``(*B,)`` of segments (start, end) ``(*B, 6)``.

    With the points p₁ + s d₁ and p₂ + t d₂: first the s that is nearest on the two lines, then t for
    this s, then s for this t, each clamped to its segment (Ericson, Real-Time Collision Detection, 5.1.9).
    """
    start_1, direction_1 = first[..., :3], first[..., 3:] - first[..., :3]
    start_2, direction_2 = second[..., :3], second[..., 3:] - second[..., :3]

    with torch.no_grad():  # no derivative of s and t: the distance is stationary there, or they are clamped
        s, t = _nearest_parameters(direction_1, direction_2, start_1 - start_2)

    gap = start_1 + s.unsqueeze(-1) * direction_1 - start_2 - t.unsqueeze(-1) * direction_2
    return torch.sqrt((gap * gap).sum(-1) + 1e-18)


def _nearest_parameters(
    direction_1: Tensor, direction_2: Tensor, offset: Tensor
) -> tuple[Tensor, Tensor]:
    """s and t ``(*B,)`` in [0, 1] of the nearest points, for directions and offset ``(*B, 3)``."""
    square_1, square_2 = (direction_1 * direction_1).sum(-1), (direction_2 * direction_2).sum(-1)
    product = (direction_1 * direction_2).sum(-1)
    along_1, along_2 = (direction_1 * offset).sum(-1), (direction_2 * offset).sum(-1)

    determinant = (square_1 * square_2 - product * product).clamp(min=1e-12)  # 0 if parallel
    s = ((product * along_2 - square_2 * along_1) / determinant).clamp(0.0, 1.0)
    t = ((product * s + along_2) / square_2.clamp(min=1e-12)).clamp(0.0, 1.0)
    s = ((product * t - along_1) / square_1.clamp(min=1e-12)).clamp(0.0, 1.0)
    return s, t
