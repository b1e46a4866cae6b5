"""The view of a task's world at one step, and the rectangle that it shows."""

from abc import ABC, abstractmethod

import numpy as np
from matplotlib.axes import Axes

from aicon_baselines.evaluation.recording import FloatArray


class WorldView(ABC):
    """The world at one step, which can be brought to another.

    Args:
        axes: Where to draw.
    """

    def __init__(self, axes: Axes) -> None:
        self.axes = axes
        axes.set(aspect="equal", xticks=[], yticks=[])
        axes.spines[:].set_color("0.6")

    @abstractmethod
    def show(self, step: int) -> None:
        """Bring the picture, and the time above it, to a step."""

    def set_title(self, title: str, size: float) -> None:
        """Write a title above the picture, in pt."""
        self.axes.set_title(title, loc="left", fontsize=size, pad=4)

    def set_time(self, time: float, size: float) -> None:
        """Write the time above the picture, s, in pt."""
        self.axes.set_title(f"{time:.1f} s", loc="right", fontsize=size, color="0.35", pad=4)


def rectangle_around(
    points: FloatArray, margin: float, aspect: float
) -> tuple[FloatArray, FloatArray]:
    """The smallest rectangle of an aspect that contains points.

    Args:
        points: The points, (N, 2).
        margin: Least distance of the points to the rectangle's edges.
        aspect: Width over height.

    Returns:
        The corners with the least and with the largest coordinates.
    """
    low, high = points.min(axis=0) - margin, points.max(axis=0) + margin
    width, height = high - low

    size = np.array([max(width, aspect * height), max(height, width / aspect)])
    center = (low + high) / 2

    return center - size / 2, center + size / 2
