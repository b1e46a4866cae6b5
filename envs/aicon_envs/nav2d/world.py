"""A navigation problem: obstacles, a start and a target."""

from collections.abc import Iterable
from typing import NamedTuple

import shapely
from shapely.geometry import Polygon, box
from shapely.geometry.base import BaseGeometry

Point = tuple[float, float]
"""Coordinates (x, y), m."""

Vertices = list[Point]
"""Corners of a polygon along its outline."""


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


def union(obstacles: Iterable[Vertices]) -> BaseGeometry:
    """Return the union of polygons as one (multi-)polygon, perhaps with holes, e.g. in a maze."""
    return shapely.union_all([Polygon(vertices) for vertices in obstacles])


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
