"""Areas, overlaps and convex parts of polygons: lists of vertices with a positive signed area."""

from collections.abc import Sequence
from itertools import combinations

import numpy as np
import shapely
from shapely.geometry import Polygon

from aicon_envs.arrays import FloatArray
from aicon_envs.pusht.geometry import Point

_CONVEX = 1e-9
"""A polygon is convex if its convex hull has at most this share more area."""


def signed_area(polygon: Sequence[Point]) -> float:
    """Return ½ Σ (x_i y_{i+1} - x_{i+1} y_i), px²."""
    total = 0.0

    x0, y0 = polygon[-1]
    for x, y in polygon:
        total += x0 * y - x * y0
        x0, y0 = x, y

    return 0.5 * total


def squared_radius_of_gyration(outline: FloatArray) -> float:
    """Return ∫ |p|² dA / A of a polygon (N, 2) about the origin, px²."""
    following = np.roll(outline, -1, axis=0)
    cross = outline[:, 0] * following[:, 1] - outline[:, 1] * following[:, 0]
    squares = (outline**2 + outline * following + following**2).sum(axis=1)
    return float((cross * squares).sum() / (6.0 * cross.sum()))


def overlap_area(subject: Sequence[Point], window: Sequence[Point]) -> float:
    """Return the area that two convex polygons have in common, px².

    The window's sides cut the subject one after the other (Sutherland & Hodgman, "Reentrant polygon
    clipping", Communications of the ACM 17, 1974). Written in plain floats: for a few vertices,
    this is faster than arrays.
    """
    start = window[-1]

    for end in window:
        subject = _cut(subject, start, end)
        if not subject:
            return 0.0
        start = end

    return signed_area(subject)


def _cut(subject: Sequence[Point], start: Point, end: Point) -> list[Point]:
    """Return the part of a convex polygon that lies left of the line from `start` to `end`."""
    ax, ay = start
    direction_x, direction_y = end[0] - ax, end[1] - ay
    kept = []

    # A vertex's side is positive to the left of the line.
    x0, y0 = subject[-1]
    side0 = direction_x * (y0 - ay) - direction_y * (x0 - ax)

    for x, y in subject:
        side = direction_x * (y - ay) - direction_y * (x - ax)

        # The edge from the last vertex to this one crosses the line.
        if (side >= 0.0) != (side0 >= 0.0):
            share = side0 / (side0 - side)
            kept.append((x0 + share * (x - x0), y0 + share * (y - y0)))

        if side >= 0.0:
            kept.append((x, y))
        x0, y0, side0 = x, y, side

    return kept


def convex_parts(outline: FloatArray) -> list[FloatArray]:
    """Cut a simple polygon with positive signed area into few convex ones.

    The triangles of a constrained Delaunay triangulation are merged while a pair that shares a side
    is convex together.
    """
    # Merging two at a time ends when no union is convex.
    triangles = shapely.constrained_delaunay_triangles(Polygon(outline))
    parts = list(shapely.get_parts(triangles))

    while (pair := _find_convex_pair(parts)) is not None:
        first, second, merged = pair
        parts = [part for part in parts if part is not first and part is not second]
        parts.append(merged)

    return [shapely.get_coordinates(shapely.orient_polygons(part))[:-1] for part in parts]


def _find_convex_pair(parts: list[Polygon]) -> tuple[Polygon, Polygon, Polygon] | None:
    """Return the first two parts whose union is a convex polygon, and that union."""
    for first, second in combinations(parts, 2):
        union = shapely.union(first, second)
        hull = union.convex_hull

        if isinstance(hull, Polygon) and hull.area - union.area <= _CONVEX * hull.area:
            return first, second, hull

    return None
