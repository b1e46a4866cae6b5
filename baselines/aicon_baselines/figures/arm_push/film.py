"""The film: the arm from outside and from the hand, above its gradients and its errors."""

from pathlib import Path

from matplotlib.figure import Figure
from PIL import Image

from aicon_baselines.evaluation.recording import track
from aicon_baselines.figures.arm_push.recording import ArmRecording
from aicon_baselines.figures.arm_push.timeline import add_timelines
from aicon_baselines.figures.arm_push.view import CameraView
from aicon_baselines.figures.film import Film
from aicon_baselines.figures.rendering import EVEN_PALETTE, is_moving_picture, render, save_video
from aicon_baselines.figures.timeline import TimeCursor
from aicon_baselines.files import replacing

_FASTER = 5
"""How much faster than real time a moving picture plays."""


class ArmFilm(Film):
    """Both views above the strengths of the gradients and the errors.

    Args:
        recording: The episode.
        dpi: Pixels per inch.
    """

    def __init__(self, recording: ArmRecording, dpi: int = 100) -> None:
        self.figure = Figure(figsize=(9.6, 6.4), dpi=dpi)
        self._recording = recording

        # Side by side, as large as their pictures allow.
        left = self.figure.add_axes((0.01, 0.44, 0.54, 0.51))
        right = self.figure.add_axes((0.56, 0.44, 0.43, 0.51))
        self._views = (
            CameraView(left, "outside", recording.outside),
            CameraView(right, "camera in the hand", recording.hand),
        )

        timelines = add_timelines(self.figure, recording)
        self._cursor = TimeCursor(timelines, "black", width=1.0)

    def show(self, step: int) -> None:
        """Bring views and cursors to a frame of the recording."""
        for view in self._views:
            view.show(step)
        self._cursor.move(self._recording.times[step])


def draw_still(recording: ArmRecording, path: Path) -> None:
    """Save the frame in the middle of the film as a png."""
    film = ArmFilm(recording)
    film.show(len(recording.times) // 2)
    with replacing(path) as place:
        Image.fromarray(render(film.figure)).save(place)


def draw_film(recording: ArmRecording, path: Path, *, progress: bool = False) -> None:
    """Save the episode as a video, mp4, webp or gif by the name of the file.

    An mp4 plays in real time, a moving picture five times as fast; the last frame rests a second.

    Args:
        recording: The episode.
        path: Where to save the video.
        progress: Whether to show a progress bar, on a terminal only.

    Raises:
        ComparisonError: If imageio is not installed and the video is an mp4.
    """
    small = is_moving_picture(path)
    film = ArmFilm(recording, dpi=60 if small else 100)
    rate = round(1 / recording.time_step)
    steps = track(range(0, len(recording.times), _FASTER if small else 1), "video", progress)
    save_video(film.frames(steps, hold=rate), path, rate, EVEN_PALETTE)
