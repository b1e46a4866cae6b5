"""What a generator of maps returns, and the pieces that it draws with."""

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from shapely import affinity
from shapely.geometry import LineString
from shapely.geometry.base import BaseGeometry

from aicon_envs.nav2d.world import Point


class Sketch(NamedTuple):
    """A map before it is checked: solid (multi-)polygon, start and target, m."""

    solid: BaseGeometry
    start: Point
    target: Point


Generator = Callable[[np.random.Generator], Sketch]


def wall(points: Sequence[Point] | NDArray[np.float64], thickness: float) -> BaseGeometry:
    """Return a wall of the given thickness (m) along a polyline."""
    return LineString(points).buffer(thickness / 2.0, cap_style="flat", join_style="mitre")


def draw_thickness(rng: np.random.Generator) -> float:
    """Draw the thickness of a wall, m."""
    return float(rng.uniform(0.12, 0.25))


def polar(radius: float, angle: float) -> Point:
    """Return the point at `radius` (m) and `angle` (rad)."""
    return radius * math.cos(angle), radius * math.sin(angle)


def place(sketch: Sketch, rng: np.random.Generator) -> Sketch:
    """Turn the sketch by a random angle about the origin and mirror it in half of the cases."""
    angle, mirror = rng.uniform(-math.pi, math.pi), rng.choice((-1.0, 1.0))
    c, s = math.cos(angle), math.sin(angle)
    matrix = np.array([[c, -s * mirror], [s, c * mirror]])
    start, target = ((float(x), float(y)) for x, y in np.array([sketch.start, sketch.target]) @ matrix.T)
    return Sketch(affinity.affine_transform(sketch.solid, [*matrix.ravel(), 0.0, 0.0]), start, target)
