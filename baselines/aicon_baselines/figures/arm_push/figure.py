"""The arm's film: from outside and from the hand, above its gradients and its errors."""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from aicon_baselines.evaluation.recording import track
from aicon_baselines.figures.arm_push.recording import ArmRecording, record
from aicon_baselines.figures.rendering import Film, is_moving_picture, save_picture, save_video
from aicon_baselines.figures.summary import FigureFiles, FigureSummary
from aicon_baselines.figures.timeline import (
    TimeCursor,
    curve_handles,
    gaps_at_zero,
    prepare_timeline,
)
from aicon_baselines.palette import ANGLE, DISTANCE, GOALS, INK, TOWARDS
from aicon_baselines.tasks.arm_push import TASK
from aicon_torch import make_policy

_FASTER = 5
"""How much faster than real time a moving picture plays."""


def make_figure(
    out: Path,
    seed: int = 1000,
    video: str = "mp4",
    *,
    horizon: int = 6_000,
    progress: bool = True,
) -> FigureSummary:
    """Run an episode and save `arm_push_film.png`, of its middle, and, unless "none", the video.

    The arguments are those of :func:`aicon_baselines.figures.nav2d.make_figure`, and the steps
    after which the episode ends.
    """
    files = FigureFiles(out, "arm_push_film", video)
    policy = make_policy("arm_push", **TASK.policy_options("camera")).compile()
    recording = record(policy, seed, horizon, progress=progress)

    still = ArmFilm(recording)
    still.show(len(recording.times) // 2)
    save_picture(still.figure, files.picture)
    if files.film is not None:
        draw_film(recording, files.film, progress=progress)

    duration = float(recording.times[-1])
    numbers = {"seed": seed, "ending": recording.ending, "duration_s": round(duration, 3)}
    return files.summary(f"{recording.ending} after {duration:.1f} s", numbers)


class ArmFilm(Film):
    """Both views above the strengths of the gradients and the errors."""

    def __init__(self, recording: ArmRecording, dpi: int = 100) -> None:
        self.figure = Figure(figsize=(9.6, 6.4), dpi=dpi)
        self._recording = recording

        # Side by side, as large as their pictures allow.
        views = (
            ("outside", recording.outside, (0.01, 0.44, 0.54, 0.51)),
            ("camera in the hand", recording.hand, (0.56, 0.44, 0.43, 0.51)),
        )
        self._views = []
        for title, pictures, place in views:
            axes = self.figure.add_axes(place)
            axes.set_axis_off()
            axes.set_title(title, fontsize=10)
            self._views.append((axes.imshow(pictures[0]), pictures))

        strengths = self.figure.add_axes((0.08, 0.23, 0.67, 0.17))
        errors = self.figure.add_axes((0.08, 0.07, 0.67, 0.13))
        draw_curves(strengths, errors, recording)
        self._cursor = TimeCursor((strengths, errors), INK)

    def show(self, step: int) -> None:
        """Bring views and cursors to a frame of the recording."""
        for image, pictures in self._views:
            image.set_data(pictures[step])
        self._cursor.move(self._recording.times[step])


def draw_film(recording: ArmRecording, path: Path, *, progress: bool = False) -> None:
    """Save the episode as a video, whose last frame rests a second.

    An mp4 plays in real time, a moving picture five times as fast.
    """
    small = is_moving_picture(path)
    film = ArmFilm(recording, dpi=60 if small else 100)
    rate = round(1 / recording.time_step)
    steps = track(range(0, len(recording.times), _FASTER if small else 1), "video", progress)
    save_video(film.frames(steps, hold=rate), path, rate)


def draw_curves(strengths: Axes, errors: Axes, recording: ArmRecording) -> None:
    """Draw the strength of each gradient; the errors and the height of the tip below it."""
    for axes in (strengths, errors):
        prepare_timeline(axes, recording)
        axes.set(yscale="log")
        axes.tick_params(labelsize=8)

    for (label, values), color in zip(recording.strengths.items(), GOALS, strict=False):
        shown = gaps_at_zero(values)
        strengths.plot(recording.times, shown, ".", color=color, label=label, markersize=3)
    strengths.set_ylabel("gradients", fontsize=9)

    curves = (
        ("distance, mm", DISTANCE, recording.distance),
        ("angle, degrees", ANGLE, recording.angle),
        ("height of the tip, mm", TOWARDS, recording.height),
    )
    for label, color, values in curves:
        shown = np.maximum(values, 0.1)
        errors.plot(recording.times, shown, color=color, label=label, linewidth=1.2)
    errors.set_xlabel("s", fontsize=9)

    for axes in (strengths, errors):
        handles = curve_handles([axes], explorations=axes is strengths)
        axes.legend(
            handles=handles,
            loc="upper left",
            bbox_to_anchor=(1.01, 1.05),
            fontsize=7.5,
            frameon=False,
        )
