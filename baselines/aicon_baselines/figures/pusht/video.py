"""The video: the episode in real time above its pose error and the strengths of its gradients."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from numpy.typing import NDArray

from aicon_baselines.figures.pictures import OnStep, pixels, save_video
from aicon_baselines.figures.pusht.panels import phase
from aicon_baselines.figures.pusht.recording import Recording
from aicon_baselines.figures.pusht.strip import draw_cost, draw_strengths
from aicon_baselines.figures.pusht.style import (
    COST,
    DETRIMENTAL,
    EXPLORING,
    GOAL,
    GOAL_TINT,
    GROUND_TINT,
    INK,
    MOTION,
    OBJECT,
    OUTLINE,
    PUSHER,
    STRIP_TINT,
    USEFUL,
    WALL,
)
from aicon_baselines.figures.pusht.view import View


def draw_video(recording: Recording, path: Path, on_step: OnStep = lambda: None) -> None:
    """Save the episode as a video in real time, mp4 or gif by the name of the file.

    Args:
        recording: The episode.
        path: Where to save the video.
        on_step: Called after every picture; there are n + 1.

    Raises:
        ComparisonError: If imageio is not installed and the video is no gif.
    """
    dpi = 60 if path.suffix == ".gif" else 100
    save_video(_pictures(recording, dpi, on_step), path, _rate(recording), _colours())


def _pictures(recording: Recording, dpi: int, on_step: OnStep) -> Iterator[NDArray[np.uint8]]:
    """The pictures of a video, (height, width, 3); the last one rests for a second."""
    figure = Figure(figsize=(8, 7.04), dpi=dpi)
    view = View(figure.add_axes((0.015, 0.225, 0.97, 0.735)), recording)
    cost, strengths = figure.add_axes((0.098, 0.112, 0.887, 0.07)), figure.add_axes((0.098, 0.022, 0.887, 0.07))
    draw_cost(cost, recording)
    draw_strengths(strengths, recording)
    for axes, label in ((cost, "pose error"), (strengths, "gradients")):
        axes.set(xticks=[], yticks=[], xlabel="")
        axes.set_ylabel(label, fontsize=9, rotation=0, ha="right", va="center")
    strengths.legend(loc="lower right", bbox_to_anchor=(1.01, 2.25), ncols=3, frameon=False, fontsize=8.5)
    cursors = [axes.axvline(0.0, color=PUSHER, linewidth=1.4) for axes in (cost, strengths)]
    for moment in range(recording.steps + 1):
        view.show(moment)
        view.entitle(phase(recording, moment), size=11)
        for cursor in cursors:
            cursor.set_xdata([recording.times[moment]])
        picture = pixels(figure)
        yield picture
        on_step()
    for _ in range(_rate(recording)):
        yield picture


def _rate(recording: Recording) -> int:
    """Pictures per second: one a step, in real time."""
    return round(1 / recording.policy.model.dt)


def _colours() -> NDArray[np.float64]:
    """The colours of a gif: the marks on white, with their soft edges, pale ones and shades of grey."""
    marks = np.array(
        [to_rgb(mark) for mark in (PUSHER, USEFUL, DETRIMENTAL, EXPLORING, OBJECT, OUTLINE, GOAL, COST, INK, MOTION)]
    )
    soft = [1 - share * (1 - marks) for share in (1.0, 0.8, 0.6, 0.4, 0.2)]
    areas = ((EXPLORING, STRIP_TINT), (EXPLORING, GROUND_TINT), (GOAL, GOAL_TINT), (WALL, 1.0))
    pale = [1 - share * (1 - np.array(to_rgb(colour))) for colour, share in areas]
    greys = np.linspace(0, 1, 24)[:, np.newaxis].repeat(3, axis=1)
    return np.concatenate([*soft, pale, greys])
