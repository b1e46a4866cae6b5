"""The picture: a row for each robot, with moments of its episode and its curves."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from aicon_baselines.figures.reach.recording import ReachRecording
from aicon_baselines.figures.rendering import save_picture
from aicon_baselines.palette import ANGLE, AWAY, DISTANCE, EXPLORING

MOMENTS = (0.0, 1 / 3, 2 / 3, 1.0)
"""What is shown of an episode, as shares of its pictures."""

ZOOM = slice(45, 435)
"""What is shown of a picture, in both directions, px."""


def draw_picture(recordings: Sequence[ReachRecording], path: Path) -> None:
    """Save the picture as a png."""
    count = len(recordings)
    figure = Figure(figsize=(12.0, 2.75 * count), dpi=100)
    widths = [1.0] * len(MOMENTS) + [1.5]
    area = {"left": 0.005, "right": 0.95, "top": 1 - 0.28 / (2.75 * count), "wspace": 0.03}
    cells = figure.add_gridspec(
        count, len(widths) + 1, width_ratios=[*widths[:-1], 0.25, widths[-1]], bottom=0.08, **area
    )

    for row, recording in enumerate(recordings):
        for column, share in enumerate(MOMENTS):
            _draw_moment(figure.add_subplot(cells[row, column]), recording, share)
        axes = figure.add_subplot(cells[row, -1])
        _draw_curves(axes, recording)
        if row == 0:
            axes.legend(loc="upper right", fontsize=7.5, frameon=False)
    axes.set_xlabel("time, s")
    save_picture(figure, path)


def _draw_moment(axes: Axes, recording: ReachRecording, share: float) -> None:
    """Draw the robot at a share of its episode."""
    number = round(share * (len(recording.frames) - 1))
    time = share * recording.times[-1]
    axes.imshow(recording.frames[number][ZOOM, ZOOM])
    axes.set(xticks=[], yticks=[])
    axes.spines[:].set_color("0.6")

    name = f"{recording.robot}, {time:.1f} s" if share == 0.0 else f"{time:.1f} s"
    axes.set_title(name, loc="left", fontsize=10, pad=4)


def _draw_curves(axes: Axes, recording: ReachRecording) -> None:
    """Draw what is missing, and what is left to what must not be touched."""
    times = recording.times
    curves = {
        "distance to the target, m": (recording.distance, DISTANCE),
        "angle to the target, rad": (recording.angle, ANGLE),
        "gap to itself (up to 0.05), m": (recording.self_gap, AWAY),
        "joint to its stop, rad": (recording.limit_margin, EXPLORING),
    }
    for label, (values, color) in curves.items():
        axes.plot(times, np.maximum(values, 1e-4), color=color, label=label, linewidth=1.3)

    axes.set(yscale="log", ylim=(3e-3, 10.0), xlim=(0.0, times[-1]))
    axes.spines[["top", "right"]].set_visible(False)
    axes.tick_params(labelsize=8)
