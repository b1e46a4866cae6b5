"""Polygons in numpy: corners ``(N, 2)`` in order, clockwise or not, and points about them."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


def rotation_matrix(angle: float) -> Array:
    """The rotation by an angle (rad) in the plane, ``(2, 2)``."""
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([[cos, -sin], [sin, cos]])


def place(corners: Array, pose: Array) -> Array:
    """The corners of a polygon whose frame is at (x, y, θ) ``(3,)``, ``(N, 2)``."""
    placed: Array = corners @ rotation_matrix(pose[2]).T + pose[:2]
    return placed


def signed_distance(points: Array, corners: Array) -> tuple[Array, Array]:
    """Distance of points to the nearest side, with a sign, and along what it is measured.

    Returns:
        The distance along the normal of the side, ``(n,)``, which beyond the end of the side is
        less than the distance to that end; and the unit normal, ``(n, 2)``, on the right of the
        side from its start to its end.
    """
    sides, gaps = _gaps(points, corners)
    nearest = (gaps * gaps).sum(-1).argmin(1)
    gap = gaps[np.arange(len(points)), nearest]
    side = sides[nearest]

    length = np.linalg.norm(side, axis=1, keepdims=True)
    tangent_x, tangent_y = (side / length).T
    normal = np.column_stack((tangent_y, -tangent_x))
    return (gap * normal).sum(-1), normal


def contains(points: Array, corners: Array, margin: float) -> Mask:
    """Whether points ``(n, 2)`` are in a polygon, ``(n,)``.

    Args:
        points: The points.
        corners: Of the polygon.
        margin: A point may be outside by so much; if negative, it must be inside by so much.
    """
    _, gaps = _gaps(points, corners)
    distance = np.sqrt((gaps**2).sum(-1)).min(1)
    inside = _crossings(points, corners) % 2 == 1

    kept: Mask
    if margin < 0:
        kept = inside & (distance > -margin)
    else:
        kept = inside | (distance < margin)
    return kept


def _crossings(points: Array, corners: Array) -> NDArray[np.int_]:
    """How many sides a ray from each point in the direction of x crosses, ``(n,)``."""
    x, y = points[:, :1], points[:, 1:]
    start_x, start_y = corners.T
    end_x, end_y = np.roll(corners, -1, axis=0).T

    # A level side spans no y, so that what it is divided by does not matter.
    spans = (start_y > y) != (end_y > y)
    rise = np.where(end_y == start_y, 1.0, end_y - start_y)
    crossing = start_x + (y - start_y) / rise * (end_x - start_x)

    crossings: NDArray[np.int_] = (spans & (x < crossing)).sum(1)
    return crossings


def _gaps(points: Array, corners: Array) -> tuple[Array, Array]:
    """The sides ``(N, 2)``, and from the nearest point of each to each point, ``(n, N, 2)``."""
    sides = np.roll(corners, -1, axis=0) - corners
    relative = points[:, None] - corners

    share = (relative * sides).sum(-1) / (sides * sides).sum(-1)
    nearest = share.clip(0.0, 1.0)[..., None] * sides
    return sides, relative - nearest
