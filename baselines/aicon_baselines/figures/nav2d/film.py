"""The film: the world step by step above the strengths of the paths."""

import math
from pathlib import Path

from matplotlib.figure import Figure

from aicon_baselines import palette
from aicon_baselines.evaluation.recording import track
from aicon_baselines.figures.nav2d.grid import Grid, grid_around
from aicon_baselines.figures.nav2d.recording import NavigationRecording
from aicon_baselines.figures.nav2d.timeline import draw_strengths
from aicon_baselines.figures.nav2d.view import NavigationView
from aicon_baselines.figures.rendering import Film, is_moving_picture, save_video
from aicon_baselines.figures.timeline import TimeCursor, add_curve_legend

_DURATION = 22.0  # s that a film lasts at most
_PHASES = {"p1": "Approaching the target", "p2": "Triangulating", "p3": "Keeping clear"}


class NavigationFilm(Film):
    """The world above the strengths of the paths.

    Args:
        recording: The rollout.
        grid: Where to sample the field.
        dpi: Resolution, dots per inch.
    """

    def __init__(self, recording: NavigationRecording, grid: Grid, dpi: float) -> None:
        self.figure = Figure(figsize=(8, 5.28), dpi=dpi)
        self._recording = recording

        # The world.
        self._view = NavigationView(
            self.figure.add_axes((0.015, 0.225, 0.97, 0.715)), recording, grid
        )

        # Time passes in the picture above: the axis needs no numbers.
        timeline = self.figure.add_axes((0.04, 0.035, 0.92, 0.12))
        draw_strengths(timeline, recording)
        timeline.set(yticks=[], xticks=[], xlabel="", ylabel="")
        add_curve_legend(
            timeline,
            loc="lower left",
            bbox_to_anchor=(-0.01, 0.93),
            ncols=5,
            fontsize=8,
            columnspacing=1.4,
        )
        self._cursor = TimeCursor([timeline], palette.ROBOT)

    def show(self, step: int) -> None:
        """Bring the world and the cursor to a step, 1 or later."""
        self._view.show(step)
        self._view.set_title(_phase(self._recording, step), size=10)
        self._cursor.move(self._recording.times[step])


def draw_film(
    recording: NavigationRecording, path: Path, spacing: float = 0.06, *, progress: bool = False
) -> None:
    """Save the rollout as a video, mp4, webp or gif by the name of the file.

    The last frame rests for a second.

    Args:
        recording: The rollout.
        path: Where to save the video.
        spacing: Distance of the sampled positions, m; twice as much in a moving picture.
        progress: Whether to show a progress bar, on a terminal only.

    Raises:
        ComparisonError: If imageio is not installed and the video is an mp4.
    """
    small = is_moving_picture(path)
    grid = grid_around(recording, 2.0 * spacing if small else spacing)
    film = NavigationFilm(recording, grid, dpi=60 if small else 100)

    rate = _frame_rate(path)
    steps = track(film_steps(recording, path), "video", progress)
    save_video(film.frames(steps, hold=rate), path, rate)


def film_steps(recording: NavigationRecording, path: Path) -> range:
    """The steps that a film shows; a long one skips some, to last 22 s at most."""
    stride = math.ceil(recording.steps / (_DURATION * _frame_rate(path)))
    return range(1, recording.steps, stride)


def _frame_rate(path: Path) -> int:
    """Frames per second; a moving picture stores every frame almost in full."""
    return 5 if is_moving_picture(path) else 15


def _phase(recording: NavigationRecording, step: int) -> str:
    """What the agent does, in plain words."""
    if recording.exploring[step]:
        return "Conflict: exploring along the obstacle"

    strengths = {name: values[step] for name, values in recording.strengths.items()}
    strongest = max(strengths, key=strengths.__getitem__)
    return _PHASES[strongest]
