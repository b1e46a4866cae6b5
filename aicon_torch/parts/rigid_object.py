"""A rigid object in the plane: a polygon with mass properties, registered by its corners."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import torch
from torch import Tensor

from aicon_torch.errors import OptionError
from aicon_torch.parts.planar import as_points, cross, norm, rotate
from aicon_torch.quantities import as_count
from aicon_torch.validation import numbers


@dataclass(frozen=True)
class RigidObject:
    """A polygon, and how it moves when it is pushed. Build one with :meth:`of`.

    Attributes:
        keypoints: Corners in the body frame relative to the centre of mass, in the order of the
            sensor, ``(K, 2)``, m.
        center_of_mass: In the body frame, ``(2,)``, m.
        outline_order: Indices of the corners as they follow each other around the object,
            counterclockwise with x to the right and y up: the inside is on the left of each side.
        radius_of_gyration: About the centre of mass, m.
    """

    keypoints: Tensor
    center_of_mass: Tensor
    outline_order: tuple[int, ...]
    radius_of_gyration: float

    @classmethod
    def of(
        cls,
        keypoints: Sequence[Sequence[float]],
        outline_order: Sequence[int] | None = None,
        center_of_mass: Sequence[float] | None = None,
        radius_of_gyration: float | None = None,
    ) -> "RigidObject":
        """The object with these corners, of uniform density unless told otherwise.

        Args:
            keypoints: Corners in the body frame, m.
            outline_order: Their order around the object, in either sense; by default the order in
                which they are given.
            center_of_mass: In the body frame, m, if it is not the polygon's.
            radius_of_gyration: In m, if it is not the polygon's.

        Raises:
            OptionError: If these are no corners of a polygon with an area.

        Example:
            >>> square = RigidObject.of([(0.0, 0.0), (0.1, 0.0), (0.1, 0.1), (0.0, 0.1)])
        """
        corners = _corners(keypoints)
        order = _order(outline_order, corners)

        area, centroid, squared_gyration = _moments(corners[order])
        if not abs(area) > 0:
            raise OptionError("keypoints: expected corners of a polygon with an area.")

        # Counterclockwise, so that the inside is on the left of each side.
        if area < 0:
            order.reverse()

        center = centroid
        if center_of_mass is not None:
            given = numbers("center_of_mass", center_of_mass, 2)
            center = torch.tensor(given, dtype=torch.float64)

        gyration = squared_gyration**0.5
        if radius_of_gyration is not None:
            gyration = numbers("radius_of_gyration", radius_of_gyration, 1)[0]
        if not gyration > 0:
            raise OptionError(
                f"radius_of_gyration={radius_of_gyration!r}: expected a positive number of m."
            )
        return cls(corners - center, center, tuple(order), float(gyration))

    @property
    def radius(self) -> float:
        """Distance of the farthest corner from the centre of mass, m."""
        return float(torch.linalg.vector_norm(self.keypoints, dim=-1).max())

    def pose_variances(self, deviation: float) -> tuple[float, float, float]:
        """Variances of x, y and θ, m², m² and rad².

        Args:
            deviation: Standard deviation of the position, and of a point at the radius of gyration
                by the rotation, m.
        """
        position = deviation**2
        return position, position, position / self.radius_of_gyration**2

    def sides(self, x_keypoints: Tensor) -> Tensor:
        """The sides (start, end) around the object, in the order of the outline.

        Args:
            x_keypoints: Corners in the order of the sensor, ``(*B, K, 2)``, m.

        Returns:
            ``(*B, K, 4)``, m.
        """
        # Each side ends where the next one begins.
        ends = (*self.outline_order[1:], self.outline_order[0])
        pairs = tuple(zip(self.outline_order, ends, strict=True))
        return x_keypoints[..., pairs, :].flatten(-2)

    def keypoints_at(self, pose: Tensor) -> Tensor:
        """The keypoints R(θ) rᵢ + (x, y) of an object at a pose.

        Args:
            pose: Centre of mass and orientation (x, y, θ), ``(*B, 3)``, m and rad.

        Returns:
            ``(*B, K, 2)``, m.
        """
        return rotate(self.keypoints.to(pose), pose[..., 2:]) + pose[..., None, :2]

    def registration(self, x_keypoints: Tensor, share: Tensor | None = None) -> Tensor:
        """The pose whose keypoints are nearest to these in the least-squares sense.

        The optimal rotation in the plane has the angle of Σᵢ wᵢ (rᵢ · kᵢ, rᵢ × kᵢ), where rᵢ are
        the keypoints in the body frame and kᵢ those that are seen, both taken from their means
        (Kabsch 1976).

        Args:
            x_keypoints: Corners in the order of the sensor, ``(*B, K, 2)``, m.
            share: wᵢ, by how much each counts, ``(*B, K)``, 1 in all; None for all the same.

        Returns:
            Centre of mass and orientation (x, y, θ), ``(*B, 3)``, m and rad.
        """
        body = self.keypoints.to(x_keypoints)
        body_mean, seen_mean = body.mean(0), x_keypoints.mean(-2)
        if share is not None:
            body_mean, seen_mean = share @ body, (share.unsqueeze(-2) @ x_keypoints).squeeze(-2)

        # The rotation, from the keypoints about their means.
        arms = body - body_mean.unsqueeze(-2)
        if share is not None:
            arms = share.unsqueeze(-1) * arms
        body_x, body_y = arms.unbind(-1)
        seen_x, seen_y = (x_keypoints - seen_mean.unsqueeze(-2)).unbind(-1)
        cos = (body_x * seen_x + body_y * seen_y).sum(-1)
        sin = (body_x * seen_y - body_y * seen_x).sum(-1)
        angle = torch.atan2(sin, cos)

        # The translation brings the means together.
        position = seen_mean - rotate(body_mean, angle)
        return torch.cat((position, angle.unsqueeze(-1)), dim=-1)

    def pose_of_frame(self, frame: Tensor) -> Tensor:
        """The pose of an object whose body frame is somewhere.

        Args:
            frame: Origin and orientation of the body frame (x, y, θ), ``(*B, 3)``, m and rad.

        Returns:
            Centre of mass and orientation, ``(*B, 3)``, m and rad.
        """
        offset = rotate(self.center_of_mass.to(frame), frame[..., 2])
        return torch.cat((frame[..., :2] + offset, frame[..., 2:]), dim=-1)


@dataclass(frozen=True)
class RigidShape:
    """Which readings of keypoints can be those of a body: see :class:`aicon_torch.Sensor`.

    Attributes:
        body: The body.
        tolerance: Largest distance of a keypoint from where the body has it that fits all of them
            best, m.
    """

    body: RigidObject
    tolerance: float

    def __call__(self, reading: Tensor) -> Tensor:
        """Which rows ``(*B,)`` of keypoints ``(*B, 2K)``, m, have the body's shape."""
        points = as_points(reading)
        placed = self.body.keypoints_at(self.body.registration(points))
        return norm(points - placed).amax(-1) <= self.tolerance


def _corners(keypoints: Sequence[Sequence[float]]) -> Tensor:
    """The corners as a tensor ``(K, 2)``, m."""
    is_sequence = hasattr(keypoints, "__len__") and not isinstance(keypoints, str)
    if not is_sequence or len(keypoints) < 3:
        raise OptionError(f"keypoints={keypoints!r}: expected 3 or more corners (x, y) in m.")
    return torch.tensor(
        [numbers("keypoints", corner, 2) for corner in keypoints], dtype=torch.float64
    )


def _order(outline_order: Sequence[int] | None, corners: Tensor) -> list[int]:
    """The order of the corners ``(K, 2)`` around a simple polygon, in the sense that was given."""
    count = len(corners)
    order = list(range(count))
    if outline_order is not None:
        given = outline_order if isinstance(outline_order, Iterable) else ()
        order = [as_count(index) for index in given]

    if sorted(order) != list(range(count)):
        raise OptionError(
            f"outline_order={outline_order!r}: expected each of the {count} keypoints once."
        )
    if not _is_simple(corners[order]):
        raise OptionError(
            f"outline_order={outline_order!r}: two sides cross; "
            "expected the order of the keypoints around the object."
        )
    return order


def _is_simple(polygon: Tensor) -> bool:
    """Whether no two sides of a polygon ``(K, 2)`` cross."""
    ends = polygon.roll(-1, 0)
    start, end = polygon[:, None], ends[:, None]
    other_start, other_end = polygon[None], ends[None]

    # Two sides cross if each has the ends of the other on different sides of its line.
    side, other_side = end - start, other_end - other_start
    parted = cross(side, other_start - start) * cross(side, other_end - start) < 0
    parts = cross(other_side, start - other_start) * cross(other_side, end - other_start) < 0
    return not bool((parted & parts).any())


def _moments(polygon: Tensor) -> tuple[float, Tensor, float]:
    """Signed area, centroid ``(2,)`` and squared radius of gyration of a polygon ``(K, 2)``."""
    # About the mean of the corners, so that an object far away loses no digits.
    origin = polygon.mean(0)
    starts = polygon - origin
    ends = starts.roll(-1, 0)
    products = cross(starts, ends)
    area = float(products.sum()) / 2
    if area == 0:
        return 0.0, origin, 0.0

    # Each side spans a triangle with the origin; sums over the triangles.
    centroid = ((starts + ends) * products.unsqueeze(-1)).sum(0) / (6 * area)
    squares = (starts * starts + starts * ends + ends * ends).sum(-1)
    second_moment = float((products * squares).sum()) / (12 * area)

    # About the centroid, by the parallel axis theorem.
    return area, centroid + origin, second_moment - float(centroid @ centroid)
