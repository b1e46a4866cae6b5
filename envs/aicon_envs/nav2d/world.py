"""A navigation problem: obstacles, a start and a target."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from gymnasium.error import DependencyNotInstalled
from numpy.typing import NDArray

try:
    import shapely
    from shapely.geometry import Polygon, box
    from shapely.geometry.base import BaseGeometry
except ImportError as error:
    raise DependencyNotInstalled('navigation needs shapely: pip install "aicon-torch"') from error

Point = tuple[float, float]
"""Coordinates (x, y), m."""

Vertices = list[Point]
"""Corners of a polygon along its outline."""


_MANY = 1000
"""From so many polygons on, those that meet no other are kept out of the slow part of a union.

That may change where an outline begins, hence the last bits of a distance; so it is not done in
the generated maps, which have far fewer.
"""


class NavigationMap(NamedTuple):
    """A world to navigate in.

    Attributes:
        name: Class of the map, or "user".
        obstacles: Simple polygons (no holes), each a list of vertices (x, y) in metres; they may
            touch or overlap.
        start: Position of the agent at the start, m.
        target: Position to reach, m.
    """

    name: str
    obstacles: list[Vertices]
    start: Point
    target: Point


def union(obstacles: Sequence[Vertices]) -> BaseGeometry:
    """Return the union of polygons as one (multi-)polygon, perhaps with holes, e.g. in a maze."""
    polygons = to_polygons(obstacles)
    if len(polygons) < _MANY:
        return shapely.union_all(polygons)
    return shapely.disjoint_subset_union_all(polygons)


def to_polygons(obstacles: Sequence[Vertices]) -> NDArray[np.object_]:
    """Return n polygons of shapely, (n,), all made in one go."""
    if not obstacles:
        return np.zeros(0, np.object_)

    counts = [len(vertices) for vertices in obstacles]
    owners = np.repeat(np.arange(len(obstacles)), counts)
    rings = shapely.linearrings(np.concatenate(obstacles), indices=owners)
    return np.asarray(shapely.polygons(rings), np.object_)


def to_vertices(geometry: BaseGeometry) -> list[Vertices]:
    """Return polygons without holes that cover the same area as `geometry`.

    A polygon with a hole is cut in two along the vertical line through the hole, and its pieces
    again.
    """
    vertices: list[Vertices] = []

    for part in shapely.get_parts(geometry):
        if isinstance(part, Polygon) and part.area > 0.0:
            vertices += _cut_holes(part)

    return vertices


def _cut_holes(polygon: Polygon) -> list[Vertices]:
    if not polygon.interiors:
        closed_ring = polygon.exterior.coords
        return [[(float(x), float(y)) for x, y in closed_ring[:-1]]]

    # Cut along the vertical line through the first hole.
    left, bottom, right, top = polygon.bounds
    middle = polygon.interiors[0].centroid.x
    left_half = polygon.intersection(box(left, bottom, middle, top))
    right_half = polygon.intersection(box(middle, bottom, right, top))

    return to_vertices(left_half) + to_vertices(right_half)
