"""Collisions of the robot with itself as a goal: capsules on its links, and their distances."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import torch
from torch import Tensor, nn

from aicon_torch.differentiation import stop, values_only
from aicon_torch.errors import OptionError
from aicon_torch.parts.chain import Chain
from aicon_torch.parts.hinge import Margin, SquaredHinge
from aicon_torch.parts.link_points import LinkPoints, Point
from aicon_torch.parts.planar import norm
from aicon_torch.quantities import as_count
from aicon_torch.vectors import select

FREE_LINKS = 2
"""Links at most so far apart in the chain are not compared: neighbours always overlap."""

MOST_OF_SPHERES = 24
"""So many gaps of spheres bound an action, the smallest: where two links that are rows of spheres
lie side by side, more than a few are about as small."""


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
        capsules: The shape of the robot, or a part of it.

    Attributes:
        radii: Their radii, m.

    Raises:
        OptionError: If there is no capsule, a number of one is not finite, a radius not positive,
            or a link not one of the chain's.
    """

    def __init__(self, chain: Chain, capsules: Sequence[Capsule]) -> None:
        super().__init__()
        check_capsules(capsules, last_link=len(chain.names) + 1)
        self.count, self.are_spheres = len(capsules), all_are_spheres(capsules)
        self.radii = tuple(capsule.radius for capsule in capsules)

        # Starts, then ends, which are the same points of spheres.
        links = [capsule.link for capsule in capsules]
        points = [capsule.start for capsule in capsules]
        if not self.are_spheres:
            links += links
            points += [capsule.end for capsule in capsules]
        self.points = LinkPoints(chain, links, points)

    def forward(self, x_joints: Tensor) -> Tensor:
        """The C segments ``(*B, C, 6)``, m, at the joint angles ``(*B, n)``, rad."""
        points = self.points(x_joints)
        start, end = (points, points) if self.are_spheres else points.chunk(2, dim=-2)
        return torch.cat((start, end), dim=-1)

    def chosen(self, x_joints: Tensor, which: Tensor) -> Tensor:
        """Some segments ``(k, m, *B, 6)``, m, by their numbers: see :meth:`LinkPoints.chosen`."""
        numbers = which if self.are_spheres else torch.stack((which, which + self.count))
        points = self.points.chosen(x_joints, numbers)
        start, end = (points, points) if self.are_spheres else points
        return torch.cat((start, end), dim=-1)


class SelfCollision(Margin, nn.Module):
    """g = w Σ max(0, 1 − d/d₀)² over the pairs of capsules that can meet, d being their distance.

    The paper's g₄ = p_collision(x_body).

    Args:
        capsules: The shape of the robot.
        cost: Margin d₀ (m) and weight w.
        pairs: The numbers of those that can meet; by default all that are further apart in the
            chain than :data:`FREE_LINKS`.
        chain: Where it is given, the joints are read instead of the segments: then the slope of one
            of many gaps takes the motion of two links only.

    Raises:
        OptionError: As for :class:`CapsuleSegments`, or if a pair is not of two of the capsules.
    """

    first: Tensor
    second: Tensor
    radii: Tensor

    def __init__(
        self,
        capsules: Sequence[Capsule],
        cost: SquaredHinge,
        pairs: Sequence[tuple[int, int]] | None = None,
        chain: Chain | None = None,
    ) -> None:
        super().__init__()
        check_capsules(capsules)
        self.cost = cost
        self.segments = None if chain is None else CapsuleSegments(chain, capsules)
        if pairs is None:
            pairs = distant_pairs(capsules)
        _check_pairs(pairs, len(capsules))
        first, second = torch.tensor(pairs, dtype=torch.long).reshape(-1, 2).unbind(-1)
        self.register_buffer("first", first, persistent=False)
        self.register_buffer("second", second, persistent=False)

        # The distance of two capsules is that of their segments, less both radii.
        self.are_spheres = all_are_spheres(capsules)
        if self.are_spheres:
            self.most_gaps = MOST_OF_SPHERES
        radii = [capsule.radius for capsule in capsules]
        single = torch.tensor(radii, dtype=torch.float64)
        self.register_buffer("radii", single[first] + single[second])

    def forward(self, x_body: Tensor) -> Tensor:
        """The cost ``(*B,)`` of the segments ``(*B, C, 6)``, m, or of the joints ``(*B, n)``."""
        return self.cost(self.distances(x_body))

    def gap(self, x_body: Tensor, pair: Tensor) -> Tensor:
        """How far one pair is from that, ``(m, *B)``, m, by its number ``(m, *B)``.

        The segments or joints are m copies, see :meth:`aicon_torch.Goal.gap`.
        """
        first, second = self._chosen(x_body, torch.stack((self.first[pair], self.second[pair])))
        distance = self._of_segments(first, second) - self.radii.to(x_body)[pair]
        return distance - self.cost.margin

    def distances(self, x_body: Tensor) -> Tensor:
        """The distance of each pair of capsules, ``(*B, pairs)``, m; negative if they overlap."""
        if self.segments is not None:
            x_body = self.segments(x_body)
        first, second = x_body[..., self.first, :], x_body[..., self.second, :]
        return self._of_segments(first, second) - self.radii.to(x_body)

    def _chosen(self, x_body: Tensor, capsules: Tensor) -> Tensor:
        """The segments ``(2, m, *B, 6)`` of the capsules of some numbers ``(2, m, *B)``."""
        if self.segments is not None:
            return self.segments.chosen(x_body, capsules)
        return torch.stack([select(x_body, number.unsqueeze(-1)) for number in capsules])

    def _of_segments(self, first: Tensor, second: Tensor) -> Tensor:
        """The distance ``(*B,)`` of segments ``(*B, 6)``, which are points if all are spheres."""
        if self.are_spheres:
            return norm(first[..., :3] - second[..., :3])
        return segment_distance(first, second)


def all_are_spheres(capsules: Sequence[Capsule]) -> bool:
    """Whether no capsule has a length."""
    return all(capsule.start == capsule.end for capsule in capsules)


def check_capsules(capsules: Sequence[Capsule], last_link: float = math.inf) -> None:
    """Check that there are capsules, each with a size and a place, on links up to the last."""
    if not capsules:
        raise OptionError("capsules: got none; expected the shape of the robot, or of its arm.")

    for number, capsule in enumerate(capsules):
        numbers = (*capsule.start, *capsule.end, capsule.radius)
        if not (all(map(math.isfinite, numbers)) and capsule.radius > 0):
            raise OptionError(
                f"capsules[{number}]={capsule!r}: expected finite numbers, and a radius above 0 m."
            )
        if not 0 <= as_count(capsule.link) <= last_link:
            raise OptionError(
                f"capsules[{number}]={capsule!r}: expected a link from 0 to {last_link}."
            )


def moving_links(capsules: Sequence[Capsule]) -> list[int]:
    """The numbers of the capsules that are not on the base, where they could not give way.

    Raises:
        OptionError: If there are none.
    """
    check_capsules(capsules)
    moving = [number for number, capsule in enumerate(capsules) if capsule.link > 0]
    if not moving:
        raise OptionError("capsules: all are on the base; expected some on links that move.")
    return moving


def _check_pairs(pairs: Sequence[tuple[int, int]], count: int) -> None:
    """Check that each pair is of two capsules, by their numbers."""
    for pair in pairs:
        numbers = tuple(map(as_count, pair))
        if len(set(numbers)) != 2 or not all(0 <= number < count for number in numbers):
            raise OptionError(
                f"pairs: got {pair!r}; expected the numbers of two capsules, from 0 to {count - 1}."
            )


def distant_pairs(
    capsules: Sequence[Capsule], free_links: int = FREE_LINKS
) -> list[tuple[int, int]]:
    """The pairs (i, j), i > j, on links that are further apart in the chain than some number."""
    pairs: list[tuple[int, int]] = []
    for i, capsule in enumerate(capsules):
        for j, other in enumerate(capsules[:i]):
            if abs(capsule.link - other.link) > free_links:
                pairs.append((i, j))
    return pairs


def segment_distance(first: Tensor, second: Tensor) -> Tensor:
    """The distance ``(*B,)`` of segments (start, end) ``(*B, 6)``.

    With the points p₁ + s d₁ and p₂ + t d₂: first the s that is nearest on the two lines, then t
    for this s, then s for this t, each clamped to its segment (Ericson 2005, Real-Time Collision
    Detection, Sect. 5.1.9).
    """
    start_1, end_1 = torch.split(first, 3, dim=-1)
    start_2, end_2 = torch.split(second, 3, dim=-1)
    direction_1, direction_2 = end_1 - start_1, end_2 - start_2

    # No derivative of s and t: there the distance is stationary, or they are clamped.
    nearest = values_only(_nearest_parameters)
    s, t = map(stop, nearest(direction_1, direction_2, start_1 - start_2))

    gap = start_1 + s.unsqueeze(-1) * direction_1 - start_2 - t.unsqueeze(-1) * direction_2
    return norm(gap)


def _nearest_parameters(
    direction_1: Tensor, direction_2: Tensor, offset: Tensor
) -> tuple[Tensor, Tensor]:
    """Where the nearest points are: s and t ``(*B,)`` in [0, 1], for vectors ``(*B, 3)``."""
    square_1, square_2 = _dot(direction_1, direction_1), _dot(direction_2, direction_2)
    product = _dot(direction_1, direction_2)
    along_1, along_2 = _dot(direction_1, offset), _dot(direction_2, offset)

    # Parallel segments have a determinant of zero, points a square of zero.
    smallest = 1e-12
    determinant = (square_1 * square_2 - product * product).clamp(min=smallest)
    s = ((product * along_2 - square_2 * along_1) / determinant).clamp(0.0, 1.0)
    t = ((product * s + along_2) / square_2.clamp(min=smallest)).clamp(0.0, 1.0)
    s = ((product * t - along_1) / square_1.clamp(min=smallest)).clamp(0.0, 1.0)
    return s, t


def _dot(first: Tensor, second: Tensor) -> Tensor:
    """The scalar product ``(*B,)`` of vectors ``(*B, 3)``."""
    return (first * second).sum(-1)
