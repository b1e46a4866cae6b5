"""The figure of arms that reach: moments and curves of each, and a film with a ball in the way."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from PIL import Image, ImageDraw

from aicon_baselines.figures.reach.recording import STRIDE, ReachRecording, record
from aicon_baselines.figures.rendering import Frame, is_moving_picture, save_picture, save_video
from aicon_baselines.figures.summary import FigureFiles, FigureSummary
from aicon_baselines.palette import ANGLE, AWAY, DISTANCE, EXPLORING, INK
from aicon_baselines.tasks.reach import ROBOTS, TASK
from aicon_envs.reach.simulation import CONTROL_STEP
from aicon_torch import make_policy

FILMED = "ur5"
"""The robot of the film."""

MOMENTS = (0.0, 1 / 3, 2 / 3, 1.0)
"""What the picture shows of an episode, as shares of what was seen."""

ZOOM = slice(45, 435)
"""What is shown of what was seen, in both directions, px."""

_RATE = 25  # pictures a second, as they are recorded
_REST = 15  # pictures that the last one stands
_SIDE = 320  # of a moving picture, px

_CURVES = {
    "distance": ("distance to the target, m", DISTANCE),
    "angle": ("angle to the target, rad", ANGLE),
    "self_gap": ("gap to itself (up to 0.05), m", AWAY),
    "limit_margin": ("joint to its stop, rad", EXPLORING),
}


def make_figure(
    out: Path,
    seed: int = 1020,
    video: str = "mp4",
    *,
    horizon: int = 1_000,
    progress: bool = True,
) -> FigureSummary:
    """Let each robot reach for a pose and save `reach.png` and, unless "none", the video.

    The arguments are those of :func:`aicon_baselines.figures.nav2d.make_figure`, and the steps
    after which an episode ends.
    """
    files = FigureFiles(out, "reach", video)

    # The same numbers for every robot; the film has something in the way.
    options: dict[str, Any] = {"seed": seed, "horizon": horizon, "progress": progress}
    recordings = [_record(robot, f"{robot}_pose_home", **options) for robot in ROBOTS]
    draw_picture(recordings, files.picture)
    if files.film is not None:
        draw_film(_record(FILMED, f"{FILMED}_pose_home_ball", balls=1, **options), files.film)

    endings, numbers = [], {}
    for recording in recordings:
        ending = "arrived" if recording.success else "did not arrive"
        endings.append(f"{recording.robot} {ending} after {recording.times[-1]:.1f} s")
        numbers[recording.robot] = float(recording.times[-1])
    return files.summary("; ".join(endings), {"seed": seed, "times_s": numbers})


def _record(robot: str, condition: str, **options: Any) -> ReachRecording:
    """An episode of a robot in a condition of the task."""
    policy = make_policy("reach", **TASK.policy_options(condition))
    return record(policy, robot, **options)


def draw_picture(recordings: Sequence[ReachRecording], path: Path) -> None:
    """Save the picture: a row for each robot, with moments of its episode and its curves."""
    count = len(recordings)
    figure = Figure(figsize=(12.0, 2.75 * count), dpi=100)
    widths = [1.0] * len(MOMENTS) + [0.25, 1.5]
    area = {"left": 0.005, "right": 0.95, "top": 1 - 0.28 / (2.75 * count), "wspace": 0.03}
    cells = figure.add_gridspec(count, len(widths), width_ratios=widths, bottom=0.08, **area)

    for row, recording in enumerate(recordings):
        for column, share in enumerate(MOMENTS):
            _draw_moment(figure.add_subplot(cells[row, column]), recording, share)
        axes = figure.add_subplot(cells[row, -1])
        draw_curves(axes, recording)
        if row == 0:
            axes.legend(loc="upper right", fontsize=7.5, frameon=False)
    axes.set_xlabel("time, s")
    save_picture(figure, path)


def _draw_moment(axes: Axes, recording: ReachRecording, share: float) -> None:
    """Draw the robot at a share of its episode."""
    number = round(share * (len(recording.pictures) - 1))
    time = share * recording.times[-1]
    axes.imshow(recording.pictures[number][ZOOM, ZOOM])
    axes.set(xticks=[], yticks=[])
    axes.spines[:].set_color("0.6")

    name = f"{recording.robot}, {time:.1f} s" if share == 0.0 else f"{time:.1f} s"
    axes.set_title(name, loc="left", fontsize=10, pad=4)


def draw_curves(axes: Axes, recording: ReachRecording) -> None:
    """Draw what is missing, and what is left to what must not be touched."""
    times = recording.times
    for name, (label, color) in _CURVES.items():
        values = np.maximum(recording.after(name), 1e-4)
        axes.plot(times, values, color=color, label=label, linewidth=1.3)

    axes.set(yscale="log", ylim=(3e-3, 10.0), xlim=(0.0, times[-1]))
    axes.spines[["top", "right"]].set_visible(False)
    axes.tick_params(labelsize=8)


def draw_film(recording: ReachRecording, path: Path) -> None:
    """Save an episode as a video, whose last frame rests.

    A moving picture has every second frame, and is smaller.
    """
    small = is_moving_picture(path)
    stride, rate = (2, _RATE // 2) if small else (1, _RATE)
    frames = list(captioned(recording, stride))
    frames += frames[-1:] * (_REST // stride)

    if small:
        frames = [_scaled(frame) for frame in frames]
    save_video(frames, path, rate)


def captioned(recording: ReachRecording, stride: int = 1) -> Iterator[Frame]:
    """Every picture of an episode, or every second one, …, with its time and what happens."""
    last = len(recording.pictures) - 1
    for number in (*range(0, last, stride), last):
        step = min(number * STRIDE, len(recording.times))
        explores = step > 0 and bool(recording.exploring[step - 1])
        doing = "held up: exploring" if explores else "descending"
        if number == last:
            doing = "arrived" if recording.success else "did not arrive"

        picture = Image.fromarray(recording.pictures[number][ZOOM, ZOOM])
        words = f"{recording.robot}   {step * CONTROL_STEP:.1f} s   {doing}"
        color = EXPLORING if explores and number < last else INK
        ImageDraw.Draw(picture).text((12, 8), words, fill=color, font_size=21)
        yield np.asarray(picture)


def _scaled(frame: Frame) -> Frame:
    """A frame as large as moving pictures are."""
    return np.asarray(Image.fromarray(frame).resize((_SIDE, _SIDE), Image.Resampling.LANCZOS))
