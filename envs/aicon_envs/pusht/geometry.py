"""Poses, polygons and how much of one lies in another.

A pose (x, y, angle), px and rad, places a body's frame: p_world = (x, y) + R(angle) p_body. Polygons are lists of
vertices with a positive signed area.
"""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Point = tuple[float, float]
Pose = tuple[float, float, float]
FloatArray = NDArray[np.float64]


def place(points: FloatArray, pose: Pose) -> FloatArray:
    """Return points (N, 2) of a body in the world, for the body's pose, px."""
    x, y, angle = pose
    cosine, sine = math.cos(angle), math.sin(angle)
    placed: FloatArray = points @ np.array([[cosine, sine], [-sine, cosine]]) + (x, y)
    return placed


def place_point(point: Point, pose: Pose) -> Point:
    """Return one point of a body in the world, px."""
    x, y, angle = pose
    cosine, sine = math.cos(angle), math.sin(angle)
    return x + cosine * point[0] - sine * point[1], y + sine * point[0] + cosine * point[1]


def wrap(angle: float) -> float:
    """Return the angle in [-π, π), rad."""
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


def signed_area(polygon: Sequence[Point]) -> float:
    """Return ½ Σ (x_i y_{i+1} - x_{i+1} y_i), px²."""
    total = 0.0
    x0, y0 = polygon[-1]
    for x, y in polygon:
        total += x0 * y - x * y0
        x0, y0 = x, y
    return 0.5 * total


def overlap_area(subject: Sequence[Point], window: Sequence[Point]) -> float:
    """Return the area that two convex polygons have in common, px².

    The window's sides cut the subject one after the other (Sutherland & Hodgman, "Reentrant polygon clipping",
    Communications of the ACM 17, 1974). Written in plain floats: for a few vertices, this is faster than arrays.
    """
    ax, ay = window[-1]
    for bx, by in window:
        ex, ey = bx - ax, by - ay
        kept = []
        x0, y0 = subject[-1]
        inside0 = ex * (y0 - ay) - ey * (x0 - ax)
        for x, y in subject:
            inside = ex * (y - ay) - ey * (x - ax)
            if (inside >= 0.0) != (inside0 >= 0.0):
                share = inside0 / (inside0 - inside)
                kept.append((x0 + share * (x - x0), y0 + share * (y - y0)))
            if inside >= 0.0:
                kept.append((x, y))
            x0, y0, inside0 = x, y, inside
        if not kept:
            return 0.0
        subject = kept
        ax, ay = bx, by
    return signed_area(subject)
