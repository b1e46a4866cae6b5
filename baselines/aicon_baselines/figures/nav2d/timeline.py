"""The strengths of the paths and the uncertainty over time."""

from typing import Any

from matplotlib.axes import Axes
from matplotlib.ticker import LogLocator, NullLocator, StrMethodFormatter

from aicon_baselines.figures.nav2d.recording import NavigationRecording
from aicon_baselines.figures.timeline import prepare_timeline, simplify
from aicon_baselines.palette import AWAY, BELIEF, CERTAINTY, TOWARDS

_PATH_LOOKS: dict[str, dict[str, Any]] = {
    "p1": {"color": TOWARDS, "linewidth": 1.8, "label": "p₁ nearer to the target"},
    "p2": {"color": CERTAINTY, "linewidth": 1.4, "label": "p₂ less uncertainty"},
    "p3": {"color": AWAY, "linewidth": 1.4, "label": "p₃ clear of obstacles"},
}
_UNCERTAINTY_LOOK: dict[str, Any] = {
    "color": BELIEF,
    "linewidth": 1.8,
    "linestyle": (0, (4, 1.5)),
    "label": "uncertainty tr Σ",
}


def draw_strengths(axes: Axes, recording: NavigationRecording) -> None:
    """Draw the strength of each path and the uncertainty over time."""
    prepare_timeline(axes, recording)
    for name, strengths in recording.strengths.items():
        axes.plot(recording.times, strengths, **_PATH_LOOKS[name])
    axes.plot(recording.times, recording.uncertainty, **_UNCERTAINTY_LOOK)

    # Both units differ and both fall by decades: one logarithmic axis, with plain numbers.
    axes.set(yscale="log", ylim=(2e-3, 60), xlabel="time (s)")
    axes.set_ylabel("path strength,\nuncertainty (m²)")
    axes.yaxis.set_major_locator(LogLocator(numticks=6))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    simplify(axes)
