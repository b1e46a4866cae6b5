"""The view of a task's world at one step, the rectangle that it shows, and marks for its legend."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from aicon_baselines.evaluation.recording import FloatArray
from aicon_baselines.palette import TARGET


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

    def set_time(self, time: float) -> None:
        """Write the time above the picture, s."""
        self.axes.set_title(f"{time:.1f} s", loc="right", fontsize=10, color="0.35", pad=4)


class PictureView(WorldView):
    """A world that was seen by a camera.

    Args:
        axes: Where to draw.
        times: When each step was, s.
        picture_at: Returns the picture of a step, (H, W, 3).
    """

    def __init__(
        self, axes: Axes, times: FloatArray, picture_at: Callable[[int], NDArray[np.uint8]]
    ) -> None:
        super().__init__(axes)
        self._times, self._picture_at = times, picture_at
        self._image = axes.imshow(picture_at(0))

    def show(self, step: int) -> None:
        """Bring the picture, and the time above it, to a step."""
        self.set_time(self._times[step])
        self._image.set_data(self._picture_at(step))


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


def dot(color: Any, size: float, edge: str = "white") -> Line2D:
    """A dot in a legend, its size in pt."""
    looks: dict[str, Any] = {"markersize": size, "markeredgecolor": edge}
    return Line2D([], [], color=color, marker="o", linestyle="none", **looks)


def target_mark(*place: float) -> Line2D:
    """The star of a target, in a legend or at a place (x, y)."""
    x, y = ([number] for number in place) if place else ([], [])
    looks: dict[str, Any] = {"markersize": 17, "markeredgecolor": "white"}
    return Line2D(x, y, color=TARGET, marker="*", linestyle="none", zorder=6, **looks)
