"""The pose error and the strengths of the gradients over time."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import LogLocator, NullLocator

from aicon_baselines.figures.pictures import spans
from aicon_baselines.figures.pusht.recording import Recording
from aicon_baselines.figures.pusht.style import COST, DETRIMENTAL, EXPLORING, STRIP_TINT, USEFUL

_SPAN: dict[str, Any] = {"color": EXPLORING, "alpha": STRIP_TINT, "linewidth": 0}


def draw_cost(axes: Axes, recording: Recording) -> None:
    """Draw the pose error over time."""
    _prepare(axes, recording)
    axes.plot(recording.times, recording.costs, color=COST, linewidth=1.8)
    axes.set(ylim=(0, 1.08 * recording.costs.max()))
    axes.set_ylabel("pose error\ng (px)")


def draw_strengths(axes: Axes, recording: Recording) -> None:
    """Draw the strength of the strongest gradient of a useful and of a detrimental contact over time."""
    _prepare(axes, recording)
    for kind, colour, label in (
        (True, USEFUL, "strongest gradient of a useful contact"),
        (False, DETRIMENTAL, "of a detrimental contact"),
    ):
        strongest = recording.strongest(useful=kind)
        axes.plot(recording.times, np.where(strongest > 0, strongest, np.nan), color=colour, linewidth=1.6, label=label)
    axes.fill_between([], [], **_SPAN, label="exploring")
    axes.set(yscale="log", ylim=(3e-5, 1.6 * recording.strengths.max()), xlabel="time (s)")
    axes.set_ylabel("gradient\nstrength")
    axes.yaxis.set_major_locator(LogLocator(numticks=5))
    axes.yaxis.set_minor_locator(NullLocator())


def _prepare(axes: Axes, recording: Recording) -> None:
    """Shade the explorations, and set what both have in common."""
    dt = recording.policy.model.dt
    for first, end in spans(recording.exploring[:-1]):
        axes.axvspan(dt * first, dt * end, **_SPAN)
    axes.set_xlim(0, recording.times[-1])
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(alpha=0.25, linewidth=0.6)
