"""The strengths of the gradients and the errors over time."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from aicon_baselines.figures.arm_push.recording import ArmRecording
from aicon_baselines.figures.timeline import add_curve_legend, gaps_at_zero, prepare_timeline
from aicon_baselines.palette import ANGLE, DISTANCE, GOALS, TOWARDS

_SHADE = {"color": "0.9"}
_LEGEND = {"loc": "upper left", "bbox_to_anchor": (1.01, 1.05), "fontsize": 7.5}


def add_timelines(figure: Figure, recording: ArmRecording) -> tuple[Axes, Axes]:
    """Add the strengths of the gradients and, below them, the errors."""
    strengths = figure.add_axes((0.08, 0.23, 0.67, 0.17))
    errors = figure.add_axes((0.08, 0.07, 0.67, 0.13))
    _draw_strengths(strengths, recording)
    _draw_errors(errors, recording)

    for axes in (strengths, errors):
        axes.tick_params(labelsize=8)
    return strengths, errors


def _draw_strengths(axes: Axes, recording: ArmRecording) -> None:
    """Draw the strength of each gradient over time."""
    prepare_timeline(axes, recording, _SHADE)
    axes.set(yscale="log")

    gradients = recording.strengths
    colors = GOALS[: len(gradients)]
    for (label, strengths), color in zip(gradients.items(), colors, strict=True):
        shown = gaps_at_zero(strengths)
        axes.plot(recording.times, shown, ".", color=color, label=label, markersize=3)

    axes.set_ylabel("gradients", fontsize=9)
    add_curve_legend(axes, shade=_SHADE, **_LEGEND)


def _draw_errors(axes: Axes, recording: ArmRecording) -> None:
    """Draw distance and angle to the target, and the height of the tip, over time."""
    axes.set(yscale="log", xlim=(0, recording.times[-1]))
    curves = (
        ("distance, mm", DISTANCE, recording.distance),
        ("angle, degrees", ANGLE, recording.angle),
        ("height of the tip, mm", TOWARDS, recording.height),
    )
    for label, color, values in curves:
        shown = np.maximum(values, 0.1)
        axes.plot(recording.times, shown, color=color, label=label, linewidth=1.2)

    axes.set_xlabel("s", fontsize=9)
    add_curve_legend(axes, shade=None, **_LEGEND)
