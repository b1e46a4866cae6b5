"""Many still or moving objects of any shape and place as one goal, read as a table of numbers."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import torch
from torch import Tensor, nn

from aicon_torch.errors import OptionError
from aicon_torch.parts.chain import Chain
from aicon_torch.parts.hinge import Margin, SquaredHinge
from aicon_torch.parts.planar import norm
from aicon_torch.parts.self_collision import Capsule, CapsuleSegments, moving_links
from aicon_torch.parts.tip_pose import rotation_of_quaternion
from aicon_torch.quantities import as_count, as_numbers
from aicon_torch.validation import check_choice, check_count
from aicon_torch.validation import numbers as finite_numbers
from aicon_torch.vectors import select

Kind = Literal["box", "cylinder", "capsule", "sphere"]
"""What an object is."""

NUMBERS = 16
"""Numbers of an object: centre 3, rotation 9, half lengths 3, kind 1."""

BOX, CYLINDER, ROUND = 0.0, 1.0, 2.0
"""The last of them: a sphere is a capsule without length."""

LENGTHS = {"box": 3, "cylinder": 2, "capsule": 2, "sphere": 1}
"""How many numbers the size of each kind has."""

SECTIONS = 24
"""Golden sections by which the point of a segment nearest to an object is found: 1e-5 of it."""

GOLDEN = 0.6180339887498949
"""What each of them leaves of the interval."""

TURNED = 1e-3
"""By how much the products of a rotation's rows may differ from those of a rotation."""

UNEVEN = 1e-4
"""By how much the radius of what is round may differ from one axis to another, m."""

FAR = 99.0
"""Where an object is that there is not, m."""


@dataclass(frozen=True)
class Solid:
    """An object: a box, a cylinder, a capsule or a sphere, turned and placed anywhere.

    Attributes:
        kind: Which of them.
        size: m. A box has its lengths along its x, y and z axes, a cylinder its length along z and
            its radius, a capsule the length of its axis along z and its radius, a sphere its
            radius.
        position: Its centre in the frame of the base, m.
        orientation: A quaternion (w, x, y, z) of any length.

    Raises:
        OptionError: If there is no such kind, or a number is not what it may be.

    Example:
        >>> can = Solid("cylinder", (0.12, 0.03), position=(0.5, 0.0, 0.06))
        >>> shelf = Solid("box", (0.8, 0.3, 0.02), (0.6, 0.0, 0.4), (0.92, 0.0, 0.0, 0.38))
        >>> action, memory = policy.predict({"q": q, "obstacles": reading_of([can, shelf]), ...})
    """

    kind: Kind
    size: tuple[float, ...]
    position: tuple[float, float, float]
    orientation: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        """Check the kind and the numbers."""
        check_choice(self, "kind", get_args(Kind))
        count = LENGTHS[self.kind]
        lengths = as_numbers(self.size)
        given = lengths if isinstance(lengths, tuple) else ()
        if len(given) != count or not all(0 < length < math.inf for length in given):
            raise OptionError(
                f"size={self.size!r}: expected {count} numbers above 0 m for a {self.kind}, in a "
                "tuple."
            )
        finite_numbers("position", self.position, 3)
        if not any(finite_numbers("orientation", self.orientation, 4)):
            raise OptionError(f"orientation={self.orientation!r}: expected a quaternion, not zero.")

    def numbers(self) -> Tensor:
        """Centre, rotation by rows, half the lengths of the box about it, and kind, ``(16,)``."""
        kind = {"box": BOX, "cylinder": CYLINDER}.get(self.kind, ROUND)
        quaternion = torch.tensor(self.orientation, dtype=torch.float64)
        rotation = rotation_of_quaternion(quaternion).flatten()
        position = torch.tensor(self.position, dtype=torch.float64)
        rest = torch.tensor((*self._half_lengths(), kind), dtype=torch.float64)
        return torch.cat((position, rotation, rest))

    def _half_lengths(self) -> tuple[float, float, float]:
        """Half the lengths of the box about it, m."""
        if self.kind == "box":
            x, y, z = self.size
            return x / 2, y / 2, z / 2
        if self.kind == "sphere":
            (radius,) = self.size
            return radius, radius, radius
        length, radius = self.size
        return radius, radius, length / 2 + (radius if self.kind == "capsule" else 0.0)


def reading_of(solids: Sequence[Solid], count: int | None = None) -> Tensor:
    """Objects as a sensor reads them, ``(16 count,)``.

    Args:
        solids: The objects.
        count: How many a policy reads; those that there are not are far away. All by default.

    Raises:
        OptionError: If they are no Solids, more than that, or none at all.
    """
    if not isinstance(solids, Sequence) or not all(isinstance(each, Solid) for each in solids):
        raise OptionError(f"solids={solids!r}: expected a list of Solids.")
    count = len(solids) if count is None else as_count(count)
    if count < 1:
        raise OptionError(
            "solids: got none; expected some, or count=, a whole number: how many a policy reads."
        )
    if len(solids) > count:
        raise OptionError(f"solids: got {len(solids)} of them, expected at most {count}.")
    nothing = Solid("sphere", (1e-3,), (FAR, 0.0, 0.0))
    filled = [*solids, *[nothing] * (count - len(solids))]
    return torch.cat([solid.numbers() for solid in filled])


def can_be_solids(reading: Tensor) -> Tensor:
    """Which readings ``(*B, 16 count)`` can be objects, ``(*B,)``.

    A rotation has rows of length one that stand upright on each other, half lengths are above 0,
    there is each kind, and what is no box is as wide as deep, and what is round no shorter.
    """
    numbers = reading.reshape(*reading.shape[:-1], -1, NUMBERS).unbind(-1)
    rows = [numbers[3:6], numbers[6:9], numbers[9:12]]
    is_right = torch.ones_like(numbers[0], dtype=torch.bool)
    for first, row in enumerate(rows):
        for second in range(first, len(rows)):
            x, y, z = (a * b for a, b in zip(row, rows[second], strict=True))
            product = x + y + z
            is_right = is_right & ((product - float(first == second)).abs() < TURNED)

    half_x, half_y, half_z, kind = numbers[12:]
    least = torch.minimum(torch.minimum(half_x, half_y), half_z)
    as_deep, as_long = (half_x - half_y).abs() <= UNEVEN, half_z >= half_x - UNEVEN
    is_kind = (kind == BOX) | (as_deep & ((kind == CYLINDER) | ((kind == ROUND) & as_long)))
    found: Tensor = (is_right & (least > 0.0) & is_kind).all(-1)
    return found


def distance_of_point(point: Tensor, solid: Tensor) -> Tensor:
    """The signed distance ``(*B,)`` of points ``(*B, 3)`` to objects ``(*B, 16)``, m.

    In the frame of the object, with half lengths h and b = |p| − h: ‖max(b, 0)‖ + min(max b, 0). A
    cylinder has the distance to its axis instead of x, and no y. What is round is the box or line
    that remains when its radius is taken off, and that radius.

    Coordinates are taken one by one, so that what is computed of many points and objects lies in a
    row.
    """
    numbers = solid.unbind(-1)
    centre, rotation, half, kind = numbers[:3], numbers[3:12], numbers[12:15], numbers[15]

    # 1. p, the point in the frame of the object: Rᵀ, by the rows of R.
    x, y, z = (own - middle for own, middle in zip(point.unbind(-1), centre, strict=True))
    rows = zip(rotation[:3], rotation[3:6], rotation[6:], strict=True)
    local_x, local_y, local_z = (by_x * x + by_y * y + by_z * z for by_x, by_y, by_z in rows)

    # 2. b, how far it is beyond the sides of the box, or of what remains without the radius.
    radius = torch.where(kind > (CYLINDER + ROUND) / 2, half[0], 0.0)
    width = half[0]
    beyond_x = local_x.abs() - (width - radius)
    beyond_y = local_y.abs() - (half[1] - radius)
    beyond_z = local_z.abs() - (half[2] - radius)

    # 3. A cylinder has a side all around instead of those in x and y.
    is_cylinder = (kind > (BOX + CYLINDER) / 2) & (kind < (CYLINDER + ROUND) / 2)
    from_axis = norm(torch.stack((local_x, local_y), dim=-1))
    beyond_x = torch.where(is_cylinder, from_axis - width, beyond_x)
    beyond_y = torch.where(is_cylinder, -width, beyond_y)

    # 4. Outside, how far it is beyond all sides; inside, how far the nearest is, as less than 0.
    beyond = torch.stack((beyond_x, beyond_y, beyond_z), dim=-1)
    inside = beyond.amax(-1).clamp(max=0.0)
    return norm(beyond.clamp(min=0.0)) + inside - radius


class Solids(Margin, nn.Module):
    """g = w Σ max(0, 1 − dᵢⱼ/d₀)², where dᵢⱼ is the distance of capsule i to object j.

    It reads the joints, so that the slope of one of many gaps takes one link's motion only.

    Args:
        chain: The robot's joints.
        capsules: Its shape; those on its base are left out, since they cannot give way.
        count: Number N of objects.
        cost: Margin d₀ (m) and weight w.

    Raises:
        OptionError: As for :class:`CapsuleSegments`, or if no capsule is on a link that moves, or
            the count is not above 0.

    Example:
        >>> solids = Solids(arm.chain, arm.shape.capsules, 21, SquaredHinge(0.0025, 1.0))
        >>> Goal("obstacles", Interconnection(solids, ["x_joints", "z_obstacles"]), safety=True)
    """

    most_gaps = 40
    """So many of all capsules and objects bound an action, the nearest."""

    radii: Tensor
    first: Tensor
    second: Tensor

    def __init__(
        self, chain: Chain, capsules: Sequence[Capsule], count: int, cost: SquaredHinge
    ) -> None:
        super().__init__()
        self.count, self.cost = count, cost
        check_count(self, ("count",), "number of objects", least=1)
        moving = [capsules[index] for index in moving_links(capsules)]
        self.segments = CapsuleSegments(chain, moving)
        radii = [capsule.radius for capsule in moving]
        self.register_buffer("radii", torch.tensor(radii, dtype=torch.float64))

        # By the number of a gap its capsule and its object.
        numbers = torch.arange(len(moving) * count)
        self.register_buffer("first", numbers % len(moving), persistent=False)
        self.register_buffer("second", numbers // len(moving), persistent=False)

    def forward(self, x_joints: Tensor, x_obstacles: Tensor) -> Tensor:
        """The cost ``(*B,)``.

        Args:
            x_joints: Joint angles, ``(*B, n)``, rad or m.
            x_obstacles: The objects, ``(*B, 16 N)``, see :class:`Solid`.
        """
        return self.cost(self.distances(x_joints, x_obstacles))

    def gap(self, x_joints: Tensor, x_obstacles: Tensor, which: Tensor) -> Tensor:
        """How far a capsule is from that, ``(m, *B)``, m, by the number of the gap ``(m, *B)``.

        The joints and the objects are m copies, see :meth:`aicon_torch.Goal.gap`.
        """
        capsule, number = self.first[which], self.second[which]
        solid = select(self._table(x_obstacles), number.unsqueeze(-1))

        start, end = torch.split(self.segments.chosen(x_joints, capsule), 3, dim=-1)
        distance = self._of_segment(start, end, solid) - self.radii.to(x_joints)[capsule]
        return distance - self.cost.margin

    def distances(self, x_joints: Tensor, x_obstacles: Tensor) -> Tensor:
        """dᵢⱼ of each object j and capsule i, ``(*B, N C)``, m; negative where they overlap."""
        solids = self._table(x_obstacles).unsqueeze(-2)
        start, end = torch.split(self.segments(x_joints).unsqueeze(-3), 3, dim=-1)
        of_axes = self._of_segment(start, end, solids)
        return (of_axes - self.radii.to(x_joints)).flatten(-2)

    def _table(self, x_obstacles: Tensor) -> Tensor:
        """The numbers of the objects, ``(*B, N, 16)``."""
        return x_obstacles.reshape(*x_obstacles.shape[:-1], self.count, NUMBERS)

    def _of_segment(self, start: Tensor, end: Tensor, solid: Tensor) -> Tensor:
        """The signed distance ``(*B,)`` of segments, or of points, to objects ``(*B, 16)``."""
        if self.segments.are_spheres:
            return distance_of_point(start, solid)

        # Where the nearest point is has no derivative: the distance is stationary there, or it is
        # an end.
        nothing = torch.zeros_like(start) * solid[..., :1]  # of the shape of both
        start, end = start + nothing, end + nothing
        share = _nearest_on_segment(lambda point: distance_of_point(point, solid), start, end)
        return distance_of_point(start + share.unsqueeze(-1) * (end - start), solid)


@torch.no_grad()
def _nearest_on_segment(of_point: Callable[[Tensor], Tensor], start: Tensor, end: Tensor) -> Tensor:
    """Where a convex distance is least on a segment, ``(*B,)`` in [0, 1], by golden sections.

    Args:
        of_point: The distance ``(*B,)`` of a point ``(*B, 3)``.
        start: One end of the segment, ``(*B, 3)``, m.
        end: The other end.
    """

    def at(share: Tensor) -> Tensor:
        return of_point(start + share.unsqueeze(-1) * (end - start))

    low = torch.zeros_like(start[..., 0])
    high = torch.ones_like(low)
    first, second = high - GOLDEN, low + GOLDEN
    at_first, at_second = at(first), at(second)
    for _ in range(SECTIONS):
        # What is convex has its least on the side of the lower of two points.
        is_left = at_first < at_second
        low, high = torch.where(is_left, low, first), torch.where(is_left, second, high)

        # By the golden ratio the lower one is one of the next two: only the other one is new.
        kept = torch.where(is_left, first, second)
        at_kept = torch.where(is_left, at_first, at_second)
        part = GOLDEN * (high - low)  # low + high − kept would round worse in each section
        new = torch.where(is_left, high - part, low + part)
        at_new = at(new)

        # One that was kept on the left is the second of the next two.
        first, second = torch.where(is_left, new, kept), torch.where(is_left, kept, new)
        at_first = torch.where(is_left, at_new, at_kept)
        at_second = torch.where(is_left, at_kept, at_new)
    return (low + high) / 2
