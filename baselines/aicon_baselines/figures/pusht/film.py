"""The film: the episode in real time above its pose error and the strengths of its gradients."""

from pathlib import Path

from matplotlib.figure import Figure

from aicon_baselines import palette
from aicon_baselines.evaluation.recording import track
from aicon_baselines.figures.pusht.panels import phase
from aicon_baselines.figures.pusht.recording import PushRecording
from aicon_baselines.figures.pusht.timeline import add_timelines
from aicon_baselines.figures.pusht.view import PushView
from aicon_baselines.figures.rendering import Film, is_moving_picture, save_video
from aicon_baselines.figures.timeline import TimeCursor, add_curve_legend

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
    save_video(film.frames(moments, hold=rate), path, rate)
