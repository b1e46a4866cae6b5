"""The video: the world step by step above the strengths of the paths."""

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from numpy.typing import NDArray

from aicon_baselines.figures.nav2d.grid import grid_around
from aicon_baselines.figures.nav2d.recording import PATHS, Recording
from aicon_baselines.figures.nav2d.strengths import draw_strengths
from aicon_baselines.figures.nav2d.style import (
    AGENT,
    ARROW,
    BELIEF,
    EXPLORING,
    HEIGHT,
    OBSTACLE,
    STRIP_TINT,
    TARGET,
    TINT,
)
from aicon_baselines.figures.nav2d.view import View
from aicon_baselines.figures.pictures import OnStep, pixels, save_video

_SECONDS = 22.0  # a video lasts at most


def draw_video(recording: Recording, path: Path, spacing: float = 0.06, on_step: OnStep = lambda: None) -> None:
    """Save the rollout as a video, mp4 or gif by the name of the file; long ones skip steps to last 22 s at most.

    Args:
        recording: The rollout.
        path: Where to save the video.
        spacing: Distance of the sampled positions, m.
        on_step: Called after every picture; there are `len(video_steps(recording, path))`.

    Raises:
        ComparisonError: If imageio is not installed and the video is no gif.
    """
    save_video(_pictures(recording, path, spacing, on_step), path, _rate(path), _palette())


def _pictures(recording: Recording, path: Path, spacing: float, on_step: OnStep) -> Iterator[NDArray[np.uint8]]:
    """The pictures of a video, (height, width, 3); the last one rests for a second."""
    figure = Figure(figsize=(8, 5.28), dpi=60 if path.suffix == ".gif" else 100)
    view = View(figure.add_axes((0.015, 0.225, 0.97, 0.715)), recording, grid_around(recording, spacing))
    strip = figure.add_axes((0.04, 0.035, 0.92, 0.12))
    draw_strengths(strip, recording)
    strip.set(yticks=[], xticks=[], xlabel="", ylabel="")
    strip.legend(loc="lower left", bbox_to_anchor=(-0.01, 0.93), ncols=5, frameon=False, fontsize=8, columnspacing=1.4)
    cursor = strip.axvline(0.0, color=AGENT, linewidth=1.4)
    for step in video_steps(recording, path):
        view.show(step)
        view.entitle(_phase(recording, step), size=10)
        cursor.set_xdata([recording.times[step]])
        picture = pixels(figure)
        yield picture
        on_step()
    for _ in range(_rate(path)):
        yield picture


def _palette() -> NDArray[np.float64]:
    """The colours of a gif: the heights, tinted ones where it would explore, and the marks with their soft edges."""
    heights = HEIGHT(np.linspace(0, 1, 40))[:, :3]
    tint = np.array(to_rgb(EXPLORING))
    marks = np.array([to_rgb(mark) for mark in (AGENT, TARGET, BELIEF, OBSTACLE, EXPLORING, ARROW, "black")])
    soft = [
        share * marks + (1 - share) * np.array(ground) for share in (1.0, 0.5) for ground in ((1, 1, 1), heights[20])
    ]
    pale = (1 - share * (1 - tint) for share in (0.0, STRIP_TINT))
    return np.concatenate([heights, (1 - TINT) * heights + TINT * tint, *soft, list(pale)])


def video_steps(recording: Recording, path: Path) -> range:
    """The steps that a video shows."""
    return range(1, recording.steps, max(1, math.ceil(recording.steps / (_SECONDS * _rate(path)))))


def _rate(path: Path) -> int:
    """Pictures per second; a gif stores every picture almost in full."""
    return 5 if path.suffix == ".gif" else 15


def _phase(recording: Recording, step: int) -> str:
    """What the agent does, in plain words."""
    if recording.exploring[step]:
        return "Conflict: exploring along the obstacle"
    strongest = max(PATHS, key=lambda name: recording.strengths[name][step])
    return {"p1": "Approaching the target", "p2": "Triangulating", "p3": "Keeping clear"}[strongest]
