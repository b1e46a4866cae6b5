"""Polygons in numpy: corners ``(*B, N, 2)`` in order, clockwise or not, and points about them."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


def place(corners: Array, pose: Array) -> Array:
    """A polygon ``(N, 2)`` whose frame is at (x, y, θ) ``(*B, 3)``: its corners ``(*B, N, 2)``."""
    cos, sin = np.cos(pose[..., 2:]), np.sin(pose[..., 2:])
    x, y = corners.T
    placed_x = cos * x - sin * y + pose[..., :1]
    placed_y = sin * x + cos * y + pose[..., 1:2]
    return np.stack((placed_x, placed_y), axis=-1)


def signed_distance(points: Array, corners: Array) -> tuple[Array, Array]:
    """Distance of points ``(n, 2)`` to the nearest side, with a sign, and along what.

    Returns:
        The distance along the normal of the side, ``(*B, n)``, which beyond the end of the side is
        less than the distance to that end; and the unit normal, ``(*B, n, 2)``, on the right of the
        side from its start to its end.
    """
    gap_x, gap_y = _gaps(points, corners)

    # Each point is compared with the side that is nearest to it.
    nearest = (gap_x**2 + gap_y**2).argmin(-1)[..., None]
    gap_x = np.take_along_axis(gap_x, nearest, -1)[..., 0]
    gap_y = np.take_along_axis(gap_y, nearest, -1)[..., 0]

    side_x, side_y = _sides(corners)
    length = np.sqrt(side_x**2 + side_y**2)
    normal_x = np.take_along_axis(side_y / length, nearest[..., 0], -1)
    normal_y = np.take_along_axis(-side_x / length, nearest[..., 0], -1)
    distance: Array = gap_x * normal_x + gap_y * normal_y
    return distance, np.stack((normal_x, normal_y), axis=-1)


def contains(points: Array, corners: Array, margin: float) -> Mask:
    """Whether points ``(n, 2)`` are in a polygon, ``(*B, n)``.

    Args:
        points: The points.
        corners: Of the polygon.
        margin: A point may be outside by so much; if negative, it must be inside by so much.
    """
    gap_x, gap_y = _gaps(points, corners)
    distance = np.sqrt((gap_x**2 + gap_y**2).min(-1))

    # A ray that begins inside crosses an odd number of sides.
    inside = _crossings(points, corners) % 2 == 1

    kept: Mask
    if margin < 0:
        kept = inside & (distance > -margin)
    else:
        kept = inside | (distance < margin)
    return kept


def _crossings(points: Array, corners: Array) -> NDArray[np.int_]:
    """How many sides a ray from each point in the direction of x crosses, ``(*B, n)``."""
    x, y = points[:, :1], points[:, 1:]
    start_x, start_y = corners[..., None, :, 0], corners[..., None, :, 1]
    side_x, side_y = (side[..., None, :] for side in _sides(corners))

    # A level side spans no y, so that what it is divided by does not matter.
    spans = (start_y > y) != (start_y + side_y > y)
    slope = side_x / np.where(side_y == 0, 1.0, side_y)
    crossing = start_x + (y - start_y) * slope

    crossings: NDArray[np.int_] = (spans & (x < crossing)).sum(-1)
    return crossings


def _gaps(points: Array, corners: Array) -> tuple[Array, Array]:
    """From the nearest point of each side to each point, along x and y, ``(*B, n, N)`` each."""
    side_x, side_y = (side[..., None, :] for side in _sides(corners))
    relative_x = points[:, :1] - corners[..., None, :, 0]
    relative_y = points[:, 1:] - corners[..., None, :, 1]

    share = (relative_x * side_x + relative_y * side_y) / (side_x**2 + side_y**2)
    share = np.clip(share, 0.0, 1.0)
    return relative_x - share * side_x, relative_y - share * side_y


def _sides(corners: Array) -> tuple[Array, Array]:
    """The sides, along x and y, ``(*B, N)`` each."""
    sides = np.roll(corners, -1, axis=-2) - corners
    return sides[..., 0], sides[..., 1]
