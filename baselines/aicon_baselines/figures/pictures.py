"""What the figures of all tasks share: moments of an episode, marks over time, pictures and videos."""

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image

from aicon_baselines.evaluation.errors import ComparisonError

OnStep = Callable[[], object]

VIDEOS = ("mp4", "gif", "none")
"""Kinds of video, "none" among them."""


class Panel(NamedTuple):
    """One moment of an episode: its letter, its step and what happens there, in plain words."""

    letter: str
    step: int
    title: str


def check_video(video: str) -> None:
    """Raise a ComparisonError if this is no kind of video."""
    if video not in VIDEOS:
        raise ComparisonError(f"unknown video {video!r}; valid: {', '.join(VIDEOS)}")


def in_order(steps: Sequence[int], last: int) -> list[int]:
    """The steps, moved where needed so that they increase and lie within 1 to `last`."""
    moved = [0]
    for left, step in zip(reversed(range(len(steps))), steps, strict=True):
        moved.append(min(max(step, moved[-1] + 1), last - left))
    return moved[1:]


def spans(mask: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First index of each run of true values and the first one after it."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8)))
    return [(int(first), int(last)) for first, last in edges.reshape(-1, 2)]


def mark_panels(axes: Axes, panels: Sequence[Panel], dt: float) -> None:
    """Write the letter of each panel above its time, s."""
    for panel in panels:
        axes.annotate(
            panel.letter,
            (panel.step * dt, 1.0),
            (0, 2),
            ("data", "axes fraction"),
            textcoords="offset points",
            ha="center",
            fontsize=10,
            fontweight="bold",
        )


def pixels(figure: Figure) -> NDArray[np.uint8]:
    """The figure's picture, (height, width, 3)."""
    canvas: Any = FigureCanvasAgg(figure)  # matplotlib leaves its methods untyped
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[..., :3]


def save_picture(figure: Figure, path: Path) -> None:
    """Save a figure as a png, with colours in steps of four: it looks the same and is 30 % smaller."""
    fourths = np.minimum((pixels(figure).astype(np.uint16) + 2) // 4 * 4, 255)
    Image.fromarray(fourths.astype(np.uint8)).save(path, optimize=True)


def save_video(pictures: Iterable[NDArray[np.uint8]], path: Path, rate: int, colours: NDArray[np.float64]) -> None:
    """Save pictures (height, width, 3) as an mp4 or a gif, by the name of the file.

    Args:
        pictures: The pictures.
        path: Where to save the video.
        rate: Pictures per second.
        colours: The colours of a gif, (256 or fewer, 3), from 0 to 1.

    Raises:
        ComparisonError: If imageio is not installed and the video is no gif.
    """
    if path.suffix == ".gif":
        palette = Image.new("P", (1, 1))
        palette.putpalette((255 * colours).round().astype(np.uint8).tobytes())
        first, *others = (
            Image.fromarray(picture).quantize(palette=palette, dither=Image.Dither.NONE) for picture in pictures
        )
        first.save(path, save_all=True, append_images=others, duration=1000 // rate, loop=0)
        return
    try:
        import imageio.v2 as imageio  # an extra: the picture and the gif do without
    except ImportError as error:
        raise ComparisonError("mp4 needs imageio[ffmpeg]; install it or choose --video gif") from error
    writer: Any
    with imageio.get_writer(path, fps=rate, quality=6) as writer:
        for picture in pictures:
            writer.append_data(picture)
