"""Shapes in the plane: all that the worlds in it consist of."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from aicon_baselines.palette import WHITE

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Shape:
    """A polygon, filled, with an edge, or both.

    Attributes:
        points: Its corners in order, (N, 2), in the world's unit.
        layer: Higher layers cover lower ones.
        color: Of its area; "" for none.
        opacity: Of its area.
        edge: Colour of its edge; "" for none.
        width: Of its edge, pixels on a page and points on paper.
    """

    points: FloatArray
    layer: float
    color: str = ""
    opacity: float = 1.0
    edge: str = ""
    width: float = 1.4


def disc(center: ArrayLike, radius: float, layer: float, color: str) -> Shape:
    """A disc around a point (2,)."""
    points = np.asarray(center, np.float64) + radius * circle()
    return Shape(points, layer, color, edge=WHITE, width=1.0)


def star(center: ArrayLike, radius: float, layer: float, color: str) -> Shape:
    """A star with five points around a point (2,)."""
    radii = radius * np.where(np.arange(10) % 2, 0.4, 1.0)
    points = np.asarray(center, np.float64) + radii[:, np.newaxis] * circle(10)[:, ::-1]
    return Shape(points, layer, color, edge=WHITE, width=1.0)


def arrow(
    tail: ArrayLike,
    along: ArrayLike,
    shaft: float,
    head: float,
    layer: float,
    color: str,
    **edge: Any,
) -> Shape:
    """An arrow from a point (2,) along a vector (2,) to its tip.

    Args:
        tail: The point.
        along: The vector.
        shaft: Width of the shaft.
        head: Width of the head.
        layer: Higher layers cover lower ones.
        color: Of its area.
        **edge: Of the shape: colour and width of its edge.
    """
    start, way = np.asarray(tail, np.float64), np.asarray(along, np.float64)
    length = float(np.linalg.norm(way))
    neck = length - min(head, 0.6 * length)

    side = [(0.0, shaft / 2), (neck, shaft / 2), (neck, head / 2)]
    corners = [*side, (length, 0.0), *((x, -y) for x, y in reversed(side))]
    ahead = way / length
    axes = np.array([ahead, (-ahead[1], ahead[0])])
    return Shape(start + np.array(corners) @ axes, layer, color, **edge)


def believed(mean: ArrayLike, covariance: ArrayLike, layer: float, color: str) -> Shape:
    """Two standard deviations of a covariance (2, 2) around a mean (2,)."""
    points = np.asarray(mean, np.float64) + circle() @ spread_axes(covariance).T
    return Shape(points, layer, color, opacity=0.2, edge=color, width=1.8)


def spread_axes(covariance: ArrayLike) -> FloatArray:
    """Two standard deviations along the axes of a covariance (n, n), as columns."""
    variances, directions = np.linalg.eigh(np.asarray(covariance, np.float64))
    axes: FloatArray = 2.0 * np.sqrt(np.maximum(variances, 0.0)) * directions
    return axes


def circle(count: int = 48) -> FloatArray:
    """Points on the unit circle, (count, 2)."""
    angles = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    circle: FloatArray = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    return circle
