"""Curves over the time of an episode, with its explorations in the background."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from aicon_baselines.evaluation.recording import FloatArray, Recording
from aicon_baselines.figures.style import TIMELINE_TINT
from aicon_baselines.palette import EXPLORING

SHADE: Mapping[str, Any] = MappingProxyType(
    {"color": EXPLORING, "alpha": TIMELINE_TINT, "linewidth": 0}
)
"""How explorations are shaded."""


def prepare_timeline(axes: Axes, recording: Recording, shade: Mapping[str, Any] = SHADE) -> None:
    """Fit axes to the time of a recording, and shade its explorations."""
    dt = recording.time_step
    for begin, end in recording.explorations:
        axes.axvspan(dt * begin, dt * end, **shade)

    axes.set_xlim(0, recording.times[-1])


def simplify(axes: Axes) -> None:
    """Leave away the frame at the top and on the right, and draw a pale grid."""
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(alpha=0.25, linewidth=0.6)


def add_curve_legend(axes: Axes, *, shade: Mapping[str, Any] | None = SHADE, **looks: Any) -> None:
    """Add a legend with the curves from the highest to the lowest, and then the explorations.

    Args:
        axes: Axes with labelled curves.
        shade: How explorations are shaded; with None there is no entry for them.
        **looks: Arguments of matplotlib's legend.
    """
    # Curves that show nothing come last, but are named.
    lines, _ = axes.get_legend_handles_labels()
    handles: list[Any] = sorted(lines, key=_median_height, reverse=True)
    if shade is not None:
        handles.append(Patch(**shade, label="exploring"))

    axes.legend(handles=handles, frameon=False, **looks)


def _median_height(line: Line2D) -> float:
    """The median of what a curve shows, −∞ if it shows nothing."""
    heights = np.asarray(line.get_ydata(), dtype=np.float64)
    shown = heights[np.isfinite(heights)]
    return float(np.median(shown)) if len(shown) else -np.inf


def gaps_at_zero(values: FloatArray) -> FloatArray:
    """Values for a logarithmic axis, NaN where they are not above zero."""
    return np.where(values > 0, values, np.nan)


class TimeCursor:
    """A vertical line in several timelines that moves with the time.

    Args:
        timelines: The axes.
        color: The line's colour.
        width: Its width, pt.
    """

    def __init__(self, timelines: Sequence[Axes], color: str, width: float = 1.4) -> None:
        self._lines = [axes.axvline(0.0, color=color, linewidth=width) for axes in timelines]

    def move(self, time: float) -> None:
        """Move to a time, s."""
        for line in self._lines:
            line.set_xdata([time])
