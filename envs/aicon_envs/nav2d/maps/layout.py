"""What a generator of maps returns, and the pieces that it is drawn with."""

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from shapely import affinity
from shapely.geometry import LineString
from shapely.geometry.base import BaseGeometry

from aicon_envs.arrays import FloatArray
from aicon_envs.nav2d.world import Point


class Layout(NamedTuple):
    """A map before it is checked.

    Attributes:
        solid: The obstacles, one (multi-)polygon, m.
        start: Position of the agent at the start, m.
        target: Position to reach, m.
    """

    solid: BaseGeometry
    start: Point
    target: Point


LayoutGenerator = Callable[[np.random.Generator], Layout]


def wall(points: Sequence[Point] | FloatArray, thickness: float) -> BaseGeometry:
    """Return a wall of the given thickness (m) along a polyline."""
    return LineString(points).buffer(thickness / 2.0, cap_style="flat", join_style="mitre")


def draw_thickness(rng: np.random.Generator) -> float:
    """Draw the thickness of a wall, m."""
    return float(rng.uniform(0.12, 0.25))


def polar(radius: float, angle: float) -> Point:
    """Return the point at `radius` (m) and `angle` (rad)."""
    return radius * math.cos(angle), radius * math.sin(angle)


def draw_orientation(layout: Layout, rng: np.random.Generator) -> Layout:
    """Turn the layout by a random angle about the origin and mirror it in half of the cases."""
    angle = rng.uniform(-math.pi, math.pi)
    mirror = rng.choice((-1.0, 1.0))

    # Rotation times diag(1, mirror).
    cosine, sine = math.cos(angle), math.sin(angle)
    matrix = np.array([[cosine, -sine * mirror], [sine, cosine * mirror]])

    solid = affinity.affine_transform(layout.solid, [*matrix.ravel(), 0.0, 0.0])
    ends = np.array([layout.start, layout.target]) @ matrix.T
    (start_x, start_y), (target_x, target_y) = ends.tolist()
    return Layout(solid, (start_x, start_y), (target_x, target_y))
