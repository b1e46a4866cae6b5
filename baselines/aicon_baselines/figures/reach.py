"""The figure of arms that reach: moments and curves of each, and a film with a ball in the way."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from aicon_baselines.evaluation.recording import Recording, record
from aicon_baselines.figures.rendering import Frame, save_picture
from aicon_baselines.figures.rollout import Rollout, draw_film
from aicon_baselines.figures.summary import FigureFiles, FigureSummary
from aicon_baselines.figures.timeline import prepare_timeline
from aicon_baselines.figures.view import PictureView
from aicon_baselines.palette import ANGLE, AWAY, DISTANCE, OBSTACLE
from aicon_baselines.tasks.reach import ROBOTS, TASK
from aicon_torch import make_policy

FILMED = "ur5"
"""The robot of the film."""

MOMENTS = (0.0, 1 / 3, 2 / 3, 1.0)
"""What the picture shows of an episode, as shares of what was seen."""

ZOOM = slice(45, 435)
"""What is shown of what was seen, in both directions, px."""

STRIDE = 2
"""Control steps from one picture to the next; the last one is of the end."""

_CURVES = {
    "distance": ("distance to the target, m", DISTANCE),
    "angle": ("angle to the target, rad", ANGLE),
    "self_gap": ("gap to itself (up to 0.05), m", AWAY),
    "limit_margin": ("joint to its stop, rad", OBSTACLE),
}


class ReachRollout(Rollout):
    """An episode of an arm that reaches."""

    name = "reach"
    aspect = 1.0
    curves = {"errors": 1.3}
    legend_rows = 2

    def doing(self, step: int) -> str:
        """What the arm does."""
        return "Held up: exploring" if self.recording.exploring[step] else "Descending"

    def make_view(self, axes: Axes, coarseness: float = 1.0) -> PictureView:
        """What the camera saw."""
        pictures = self.recording.pictures
        return PictureView(axes, self.recording.times, lambda step: pictures[step][ZOOM, ZOOM])

    def draw_curves(self, *diagrams: Axes) -> None:
        """What is missing to the pose, and what is left to what must not be touched."""
        (axes,) = diagrams
        prepare_timeline(axes, self.recording)
        for name, (label, color) in _CURVES.items():
            values = np.maximum(self.recording.told(name)[:-1], 1e-4)
            axes.plot(self.recording.times, values, color=color, label=label, linewidth=1.3)

        axes.set(yscale="log", ylim=(3e-3, 10.0))
        axes.tick_params(labelsize=8)


def make_figure(
    out: Path, seed: int = 1000, video: str = "mp4", *, horizon: int = 1_000
) -> FigureSummary:
    """Let each robot reach for a pose and save `reach.png` and, unless "none", the video.

    The arguments are those of :func:`aicon_baselines.figures.nav2d.make_figure`, and the steps
    after which an episode ends.
    """
    files = FigureFiles(out, "reach", video)

    # The film has something in the way.
    recordings = {robot: record_reach(f"{robot}_pose_home", seed, horizon) for robot in ROBOTS}
    draw_picture(recordings, files.picture)
    if files.film is not None:
        filmed = record_reach(f"{FILMED}_pose_home_ball", seed, horizon)
        draw_film(ReachRollout(filmed), files.film)

    endings, times = [], {}
    for robot, recording in recordings.items():
        ending = "arrived" if recording.success else "did not arrive"
        times[robot] = round(recording.steps * recording.time_step, 3)
        endings.append(f"{robot} {ending} after {times[robot]:.1f} s")
    return files.summary("; ".join(endings), {"seed": seed, "times_s": times})


def record_reach(condition: str, seed: int, horizon: int) -> Recording:
    """Run an episode in a condition of the task, and keep every second step with a picture.

    Raises:
        RuntimeError: If nothing can be rendered.
    """
    size = {"render_width": 480, "render_height": 480}
    env = TASK.make_env(1, condition, horizon, render_mode="rgb_array", **size)
    reset = TASK.reset_arguments([TASK.episode(seed)])
    policy = make_policy("reach", **TASK.policy_options(condition))

    def look(_: Any) -> Frame:
        pictures: Any = env.render()
        frame: Frame = pictures[0]
        return frame

    return record(Recording, policy, env, reset, horizon, stride=STRIDE, look=look)


def draw_picture(recordings: Mapping[str, Recording], path: Path) -> None:
    """Save the picture: a row for each robot, with moments of its episode and its curves."""
    count = len(recordings)
    figure = Figure(figsize=(12.0, 2.75 * count), dpi=100)
    widths = [1.0] * len(MOMENTS) + [0.25, 1.5]
    area = {"left": 0.005, "right": 0.95, "top": 1 - 0.28 / (2.75 * count), "wspace": 0.03}
    cells = figure.add_gridspec(count, len(widths), width_ratios=widths, bottom=0.08, **area)

    for row, (robot, recording) in enumerate(recordings.items()):
        # Moments of the episode, ...
        for column, share in enumerate(MOMENTS):
            time = share * recording.steps * recording.time_step
            axes = figure.add_subplot(cells[row, column])
            axes.imshow(
                recording.pictures[round(share * (len(recording.pictures) - 1))][ZOOM, ZOOM]
            )
            axes.set(xticks=[], yticks=[])
            axes.spines[:].set_color("0.6")
            name = f"{robot}, {time:.1f} s" if share == 0.0 else f"{time:.1f} s"
            axes.set_title(name, loc="left", fontsize=10, pad=4)

        # ... and its curves.
        axes = figure.add_subplot(cells[row, -1])
        ReachRollout(recording).draw_curves(axes)
        if row == 0:
            axes.legend(loc="lower left", fontsize=7.5, frameon=False)
    axes.set_xlabel("time, s")
    save_picture(figure, path)
