"""Points and poses in the plane.

A pose (x, y, angle), px and rad, places a body's frame: p_world = (x, y) + R(angle) p_body.
"""

import math

import numpy as np

from aicon_envs.arrays import FloatArray

Point = tuple[float, float]
Pose = tuple[float, float, float]


def place(points: FloatArray, pose: Pose) -> FloatArray:
    """Return points (N, 2) of a body in the world, for the body's pose, px."""
    x, y, angle = pose
    cosine, sine = math.cos(angle), math.sin(angle)
    rotation_transposed = np.array([[cosine, sine], [-sine, cosine]])

    placed: FloatArray = points @ rotation_transposed + (x, y)
    return placed


def place_point(point: Point, pose: Pose) -> Point:
    """Return one point of a body in the world, px."""
    x, y, angle = pose
    cosine, sine = math.cos(angle), math.sin(angle)
    return (
        x + cosine * point[0] - sine * point[1],
        y + sine * point[0] + cosine * point[1],
    )


def wrap(angle: float) -> float:
    """Return the angle in [-π, π), rad."""
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


def clip(value: float, low: float, high: float) -> float:
    """Return the value, or the bound that it exceeds."""
    return min(max(value, low), high)
