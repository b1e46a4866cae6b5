"""Curves over the time of an episode, with its explorations in the background."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from aicon_baselines.evaluation.recording import FloatArray, Recording
from aicon_baselines.palette import EXPLORING

SHADE: Mapping[str, Any] = MappingProxyType({"color": EXPLORING, "alpha": 0.16, "linewidth": 0})
"""How explorations are shaded."""


def prepare_timeline(axes: Axes, recording: Recording) -> None:
    """Fit axes to the time of a recording, and shade its explorations."""
    dt = recording.time_step
    for begin, end in recording.explorations:
        axes.axvspan(dt * begin, dt * end, **SHADE)

    axes.set_xlim(0, recording.times[-1])
    simplify(axes)


def simplify(axes: Axes) -> None:
    """Leave away the frame at the top and on the right, and draw a pale grid."""
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(alpha=0.25, linewidth=0.6)


def curve_handles(diagrams: Sequence[Axes]) -> list[Any]:
    """Handles of a legend: the labelled curves from the highest to the lowest, then explorations.

    Curves that show nothing come last, but are named.
    """
    handles: list[Any] = []
    for axes in diagrams:
        lines, _ = axes.get_legend_handles_labels()
        handles += sorted(lines, key=_median_height, reverse=True)
    return [*handles, Patch(**SHADE, label="exploring")]


def _median_height(line: Line2D) -> float:
    """The median of what a curve shows, −∞ if it shows nothing."""
    heights = np.asarray(line.get_ydata(), dtype=np.float64)
    shown = heights[np.isfinite(heights)]
    return float(np.median(shown)) if len(shown) else -np.inf


def gaps_at_zero(values: FloatArray) -> FloatArray:
    """Values for a logarithmic axis, NaN where they are not above zero."""
    return np.where(values > 0, values, np.nan)


class TimeCursor:
    """A vertical line in several diagrams that moves with the time.

    Args:
        diagrams: The axes.
        color: The line's colour.
    """

    def __init__(self, diagrams: Sequence[Axes], color: str) -> None:
        self._lines = [axes.axvline(0.0, color=color, linewidth=1.4) for axes in diagrams]

    def move(self, time: float) -> None:
        """Move to a time, s."""
        for line in self._lines:
            line.set_xdata([time])
