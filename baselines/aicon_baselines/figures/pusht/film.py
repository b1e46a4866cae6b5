"""The film: the episode in real time above its pose error and the strengths of its gradients."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from aicon_baselines import palette
from aicon_baselines.evaluation.recording import FloatArray, track
from aicon_baselines.figures.film import Film
from aicon_baselines.figures.pusht.panels import phase
from aicon_baselines.figures.pusht.recording import PushRecording
from aicon_baselines.figures.pusht.timeline import add_timelines
from aicon_baselines.figures.pusht.view import GROUND_TINT, PushView
from aicon_baselines.figures.rendering import is_moving_picture, save_video
from aicon_baselines.figures.style import TIMELINE_TINT, blend
from aicon_baselines.figures.timeline import TimeCursor, add_curve_legend
from aicon_baselines.worlds.surroundings import GOAL_TINT

_COST, _STRENGTHS = (0.098, 0.112, 0.887, 0.07), (0.098, 0.022, 0.887, 0.07)


class PushFilm(Film):
    """The world above the pose error and the strengths of the gradients.

    Args:
        recording: The episode.
        dpi: Resolution, dots per inch.
    """

    def __init__(self, recording: PushRecording, dpi: float) -> None:
        self.figure = Figure(figsize=(8, 7.04), dpi=dpi)
        self._recording = recording

        # The world.
        self._view = PushView(self.figure.add_axes((0.015, 0.225, 0.97, 0.735)), recording)

        # Time passes in the picture above: the axes need no numbers.
        timelines = add_timelines(self.figure, recording, _COST, _STRENGTHS)
        for axes, label in zip(timelines, ("pose error", "gradients"), strict=True):
            axes.set(xticks=[], yticks=[], xlabel="")
            axes.set_ylabel(label, fontsize=9, rotation=0, ha="right", va="center")

        strengths = timelines[1]
        add_curve_legend(
            strengths, loc="lower right", bbox_to_anchor=(1.01, 2.25), ncols=3, fontsize=8.5
        )
        self._cursor = TimeCursor(timelines, palette.ROBOT)

    def show(self, step: int) -> None:
        """Bring the world and the cursors to a moment."""
        self._view.show(step)
        self._view.set_title(phase(self._recording, step), size=11)
        self._cursor.move(self._recording.times[step])


def draw_film(recording: PushRecording, path: Path, *, progress: bool = False) -> None:
    """Save the episode as a video, mp4, webp or gif by the name of the file.

    An mp4 plays in real time, a moving picture at half that speed. The last of the n + 1 frames
    rests for a second.

    Args:
        recording: The episode.
        path: Where to save the video.
        progress: Whether to show a progress bar, on a terminal only.

    Raises:
        ComparisonError: If imageio is not installed and the video is an mp4.
    """
    small = is_moving_picture(path)
    film = PushFilm(recording, dpi=60 if small else 100)

    rate = round((0.5 if small else 1.0) / recording.time_step)
    moments = track(range(recording.steps + 1), "video", progress)
    save_video(film.frames(moments, hold=rate), path, rate, _palette())


def _palette() -> FloatArray:
    """The colours of a gif: the marks on white, with their soft edges, pale areas and greys."""
    marks = (
        palette.ROBOT,
        palette.TOWARDS,
        palette.AWAY,
        palette.EXPLORING,
        palette.OBJECT,
        palette.OUTLINE,
        palette.GOAL,
        palette.OBSTACLE,
        palette.INK,
        palette.MOTION,
    )
    # From opaque to almost white, as the edges of the marks are.
    colors = []
    for opacity in (1.0, 0.8, 0.6, 0.4, 0.2):
        for mark in marks:
            colors.append(blend(mark, opacity))

    # Large areas need their very colour.
    areas = [
        blend(palette.EXPLORING, TIMELINE_TINT),
        blend(palette.EXPLORING, GROUND_TINT),
        blend(palette.GOAL, GOAL_TINT),
        blend(palette.WALL, 1.0),
    ]
    greys = np.linspace(0, 1, 24)[:, np.newaxis].repeat(3, axis=1)
    return np.concatenate([colors, areas, greys])
