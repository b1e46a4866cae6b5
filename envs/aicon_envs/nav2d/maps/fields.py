"""Maps with many obstacles between start and target: clutter, random unions, corridors."""

import math
from collections.abc import Callable

import numpy as np
import shapely
from shapely import affinity
from shapely.geometry import Point as ShapelyPoint
from shapely.geometry import Polygon, box
from shapely.geometry.base import BaseGeometry

from aicon_envs.nav2d.maps.sketch import Sketch, draw_thickness, polar, wall

_KEPT_CLEAR = 0.5
"""No obstacle is put closer than this to start or target, m."""


def clutter(rng: np.random.Generator) -> Sketch:
    """Small convex polygons all over the field."""
    return _scatter(rng, _pebble, count=int(rng.integers(14, 26)), length=rng.uniform(5.0, 8.0), width=5.0)


def random_unions(rng: np.random.Generator) -> Sketch:
    """A few large obstacles, each the union of crossing bars and mostly not convex."""
    return _scatter(rng, _bars, count=int(rng.integers(5, 10)), length=rng.uniform(6.0, 9.0), width=6.0)


def corridors(rng: np.random.Generator) -> Sketch:
    """A hall divided by walls across it, each with one door."""
    rooms, height, thickness = int(rng.integers(4, 7)), rng.uniform(2.5, 4.0), draw_thickness(rng)
    widths = rng.uniform(1.2, 1.7, size=rooms)
    x = np.concatenate([[0.0], np.cumsum(widths)])
    hall = box(0.0, 0.0, x[-1], height)
    walls = [hall.buffer(thickness / 2.0, join_style="mitre") - hall.buffer(-thickness / 2.0, join_style="mitre")]
    for position in x[1:-1]:
        door = rng.uniform(0.8, 1.2)
        low = rng.uniform(0.0, height - door - thickness) + thickness / 2.0
        walls.append(wall([(position, 0.0), (position, low)], thickness))
        walls.append(wall([(position, low + door), (position, height)], thickness))
    middles = (x[:-1] + x[1:]) / 2.0
    start, target = ((float(middles[room]), rng.uniform(0.55, height - 0.55)) for room in (0, -1))
    return Sketch(shapely.union_all(walls), start, target)


def _scatter(
    rng: np.random.Generator,
    draw: Callable[[np.random.Generator], BaseGeometry],
    count: int,
    length: float,
    width: float,
) -> Sketch:
    """Put `count` drawn shapes at random into a field of length × width with start and target near its ends."""
    start, target = (0.0, 0.0), (length, 0.0)
    reserved = shapely.union_all([ShapelyPoint(end).buffer(_KEPT_CLEAR) for end in (start, target)])
    shapes = [
        affinity.translate(draw(rng), rng.uniform(0.0, length), rng.uniform(-width / 2.0, width / 2.0))
        for _ in range(count)
    ]
    return Sketch(shapely.union_all([shape for shape in shapes if not shape.intersects(reserved)]), start, target)


def _pebble(rng: np.random.Generator) -> BaseGeometry:
    corners, radius = int(rng.integers(3, 8)), rng.uniform(0.2, 0.5)
    angles = rng.uniform(-math.pi, math.pi) + np.arange(corners) * 2.0 * math.pi / corners
    angles += rng.uniform(-0.3, 0.3, size=corners)
    return Polygon([polar(radius, angle) for angle in angles]).convex_hull


def _bars(rng: np.random.Generator) -> BaseGeometry:
    """Return two to four bars that cross at the origin."""
    bars: list[BaseGeometry] = []
    for _ in range(int(rng.integers(2, 5))):
        length, width, share = rng.uniform(1.0, 2.4), rng.uniform(0.2, 0.5), rng.uniform(0.1, 0.5)
        bar = box(-share * length, -width / 2.0, (1.0 - share) * length, width / 2.0)
        bars.append(affinity.rotate(bar, rng.uniform(0.0, 360.0), origin=(0.0, 0.0)))
    return shapely.union_all(bars)
