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
    along, gaps = _gaps(points, corners)
    nearest = (gaps * gaps).sum(-1).argmin(1)
    gap = gaps[np.arange(len(points)), nearest]

    tangent = along[nearest] / np.linalg.norm(along[nearest], axis=1, keepdims=True)
    normal = np.column_stack((tangent[:, 1], -tangent[:, 0]))
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
    kept: Mask = inside & (distance > -margin) if margin < 0 else inside | (distance < margin)
    return kept


def _crossings(points: Array, corners: Array) -> NDArray[np.int_]:
    """How many sides a ray from each point in the direction of x crosses, ``(n,)``."""
    x, y = points[:, 0, None], points[:, 1, None]
    start, end = corners, np.roll(corners, -1, axis=0)
    spans = (start[:, 1] > y) != (end[:, 1] > y)

    rise = end[:, 1] - start[:, 1]
    rise = np.where(rise == 0, 1.0, rise)  # a level side spans no y
    crossing = start[:, 0] + (y - start[:, 1]) / rise * (end[:, 0] - start[:, 0])
    crossings: NDArray[np.int_] = (spans & (x < crossing)).sum(1)
    return crossings


def _gaps(points: Array, corners: Array) -> tuple[Array, Array]:
    """The sides ``(N, 2)``, and from the nearest point of each to each point, ``(n, N, 2)``."""
    start, along = corners, np.roll(corners, -1, axis=0) - corners
    relative = points[:, None] - start
    share = ((relative * along).sum(-1) / (along * along).sum(-1)).clip(0.0, 1.0)
    return along, relative - share[..., None] * along
