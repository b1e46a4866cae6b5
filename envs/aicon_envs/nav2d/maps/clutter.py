"""Maps with many separate obstacles between start and target."""

import math
from collections.abc import Callable

import numpy as np
import shapely
from shapely import affinity
from shapely.geometry import Point as ShapelyPoint
from shapely.geometry import Polygon, box
from shapely.geometry.base import BaseGeometry

from aicon_envs.nav2d.maps.layout import Layout, polar
from aicon_envs.nav2d.world import Point

_KEPT_CLEAR = 0.5
"""No obstacle is put closer than this to start or target, m."""


def clutter(rng: np.random.Generator) -> Layout:
    """Small convex polygons all over the field."""
    count = int(rng.integers(14, 26))
    length = rng.uniform(5.0, 8.0)
    return _scatter(rng, _draw_pebble, count, length, width=5.0)


def random_unions(rng: np.random.Generator) -> Layout:
    """A few large obstacles, each the union of crossing bars and mostly not convex."""
    count = int(rng.integers(5, 10))
    length = rng.uniform(6.0, 9.0)
    return _scatter(rng, _draw_crossing_bars, count, length, width=6.0)


def _scatter(
    rng: np.random.Generator,
    draw_shape: Callable[[np.random.Generator], BaseGeometry],
    count: int,
    length: float,
    width: float,
) -> Layout:
    """Put `count` shapes at random into a field of length × width, start and target at its ends."""
    # Around start and target, discs stay clear.
    start: Point = (0.0, 0.0)
    target: Point = (length, 0.0)
    reserved = shapely.union(
        ShapelyPoint(start).buffer(_KEPT_CLEAR),
        ShapelyPoint(target).buffer(_KEPT_CLEAR),
    )

    obstacles = []
    for _ in range(count):
        shape = draw_shape(rng)
        x = rng.uniform(0.0, length)
        y = rng.uniform(-width / 2.0, width / 2.0)

        # Dropped only after its draws: what follows does not depend on whether it fits.
        obstacle = affinity.translate(shape, x, y)
        if not obstacle.intersects(reserved):
            obstacles.append(obstacle)

    return Layout(shapely.union_all(obstacles), start, target)


def _draw_pebble(rng: np.random.Generator) -> BaseGeometry:
    """Draw a convex polygon of 3 to 7 corners around the origin."""
    count = int(rng.integers(3, 8))
    radius = rng.uniform(0.2, 0.5)

    # Corners of a regular polygon, each moved along the circle.
    angles = rng.uniform(-math.pi, math.pi) + np.arange(count) * 2.0 * math.pi / count
    angles += rng.uniform(-0.3, 0.3, size=count)

    corners = [polar(radius, angle) for angle in angles]
    return Polygon(corners).convex_hull


def _draw_crossing_bars(rng: np.random.Generator) -> BaseGeometry:
    """Draw two to four bars that cross at the origin."""
    bars: list[BaseGeometry] = []

    for _ in range(int(rng.integers(2, 5))):
        length = rng.uniform(1.0, 2.4)
        width = rng.uniform(0.2, 0.5)
        share = rng.uniform(0.1, 0.5)  # of the length, on one side of the origin

        # Lengthwise along x, then turned about the origin.
        bar = box(-share * length, -width / 2.0, (1.0 - share) * length, width / 2.0)
        bars.append(affinity.rotate(bar, rng.uniform(0.0, 360.0), origin=(0.0, 0.0)))

    return shapely.union_all(bars)
