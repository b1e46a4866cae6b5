"""A navigation problem: obstacles, a start and a target."""

from collections.abc import Iterable
from typing import NamedTuple

import shapely
from shapely.geometry import Polygon, box
from shapely.geometry.base import BaseGeometry

Point = tuple[float, float]
Vertices = list[Point]


class NavigationMap(NamedTuple):
    """A world to navigate in.

    Attributes:
        name: Class of the map, or "user".
        obstacles: Simple polygons (no holes), each a list of vertices (x, y) in metres; they may touch or overlap.
        start: Position of the agent at the start, m.
        target: Position to reach, m.
    """

    name: str
    obstacles: list[Vertices]
    start: Point
    target: Point


def union(obstacles: Iterable[Vertices]) -> BaseGeometry:
    """Return the union of polygons as one (multi-)polygon; it may have holes, e.g. the inside of a maze."""
    return shapely.union_all([Polygon(vertices) for vertices in obstacles])


def to_vertices(geometry: BaseGeometry) -> list[Vertices]:
    """Return polygons without holes that cover the same area as `geometry`.

    A polygon with a hole is cut in two along the vertical line through the hole, and its pieces again.
    """
    polygons = [part for part in shapely.get_parts(geometry) if isinstance(part, Polygon) and part.area > 0.0]
    return [vertices for polygon in polygons for vertices in _cut_holes(polygon)]


def _cut_holes(polygon: Polygon) -> list[Vertices]:
    if not polygon.interiors:
        return [[(float(x), float(y)) for x, y in polygon.exterior.coords[:-1]]]
    left, bottom, right, top = polygon.bounds
    middle = polygon.interiors[0].centroid.x
    halves = (box(left, bottom, middle, top), box(middle, bottom, right, top))
    return [vertices for half in halves for vertices in to_vertices(polygon.intersection(half))]
