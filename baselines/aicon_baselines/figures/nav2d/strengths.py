"""The strengths of the paths and the uncertainty over time."""

from typing import Any

from matplotlib.axes import Axes
from matplotlib.ticker import LogLocator, NullLocator, StrMethodFormatter

from aicon_baselines.figures.nav2d.recording import Recording
from aicon_baselines.figures.nav2d.style import BELIEF, EXPLORING, OBSTACLE, STRIP_TINT, TARGET

_SPAN: dict[str, Any] = {"color": EXPLORING, "alpha": STRIP_TINT, "linewidth": 0}
_LINES: dict[str, dict[str, Any]] = {
    "p1": {"color": TARGET, "linewidth": 1.8, "label": "p₁ nearer to the target"},
    "p2": {"color": BELIEF, "linewidth": 1.4, "label": "p₂ less uncertainty"},
    "p3": {"color": OBSTACLE, "linewidth": 1.4, "label": "p₃ clear of obstacles"},
    "sigma": {"color": BELIEF, "linewidth": 1.8, "linestyle": (0, (4, 1.5)), "label": "uncertainty tr Σ"},
}


def draw_strengths(axes: Axes, recording: Recording) -> None:
    """Draw the strength of each path and the uncertainty over time."""
    dt = recording.policy.model.dt
    for first, last in recording.spans:
        axes.axvspan(dt * first, dt * last, **_SPAN)
    axes.fill_between([], [], **_SPAN, label="exploring")
    for name, series in (recording.strengths | {"sigma": recording.uncertainty}).items():
        axes.plot(recording.times, series, **_LINES[name])
    axes.set(yscale="log", ylim=(2e-3, 60), xlim=(0, recording.times[-1]), xlabel="time (s)")
    axes.set_ylabel("path strength,\nuncertainty (m²)")
    axes.yaxis.set_major_locator(LogLocator(numticks=6))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(alpha=0.25, linewidth=0.6)
