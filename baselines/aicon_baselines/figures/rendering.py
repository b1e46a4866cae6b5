"""Figures rendered, and saved as pictures and videos."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from aicon_baselines.extras import naming_extra, require
from aicon_baselines.files import replacing

with naming_extra():
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

Frame = NDArray[np.uint8]
"""A rendered picture, (height, width, 3)."""

VIDEO_FORMATS = ("mp4", "webp", "none")
"""Formats of a video, "none" among them."""

_QUALITY = 55  # of a webp, of 100
_CODEC_BLOCK = 2  # px; an mp4 has one colour for two by two


def is_moving_picture(path: Path) -> bool:
    """Whether a video is one that pages show as a picture, which is to be small."""
    return path.suffix == ".webp"


def render(figure: Figure) -> Frame:
    """The figure as a picture."""
    canvas: Any = FigureCanvasAgg(figure)  # matplotlib leaves its methods untyped
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[..., :3]


def mark(scene: Any, place: Any, radius: float, color: Sequence[float]) -> None:
    """Add a ball to a scene that MuJoCo renders.

    Args:
        scene: The scene of a `mujoco.Renderer`, after its update.
        place: The middle of the ball, ``(3,)``, m.
        radius: Its radius, m.
        color: Red, green, blue and opacity, each in [0, 1].
    """
    import mujoco

    ball, size, turn = mujoco.mjtGeom.mjGEOM_SPHERE, np.full(3, radius), np.eye(3).ravel()
    geom = scene.geoms[scene.ngeom]
    mujoco.mjv_initGeom(geom, ball, size, place, turn, np.array(color, np.float32))
    scene.ngeom += 1


def camera(at: Sequence[float], distance: float, azimuth: float, elevation: float) -> Any:
    """MuJoCo's camera that looks at a place.

    Args:
        at: The place, ``(3,)``, m.
        distance: From where it looks, m.
        azimuth: Its angle about z, degrees.
        elevation: Its angle above the horizon, degrees.
    """
    import mujoco

    view = mujoco.MjvCamera()
    view.lookat[:] = at
    view.distance, view.azimuth, view.elevation = distance, azimuth, elevation
    return view


def save_picture(figure: Figure, path: Path) -> None:
    """Save a figure as a png.

    Colours are rounded to steps of four: it looks the same and is 30 % smaller.
    """
    rounded = (render(figure).astype(np.uint16) + 2) // 4 * 4
    frame = np.minimum(rounded, 255).astype(np.uint8)

    with replacing(path) as place:
        Image.fromarray(frame).save(place, optimize=True)


def save_video(frames: Iterable[Frame], path: Path, rate: int) -> None:
    """Save frames as an mp4 or a webp, by the name of the file.

    Args:
        frames: The frames.
        path: Where to save the video; its folder is made if need be.
        rate: Frames per second.

    Raises:
        ComparisonError: If imageio is not installed and the video is an mp4.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    save = _save_webp if is_moving_picture(path) else _save_mp4
    with replacing(path) as place:
        save(frames, place, rate)


def _save_webp(frames: Iterable[Frame], path: Path, rate: int) -> None:
    images = [Image.fromarray(frame) for frame in frames]
    looks: dict[str, Any] = {"quality": _QUALITY, "method": 4}
    duration = 1000 // rate
    images[0].save(
        path, save_all=True, append_images=images[1:], duration=duration, loop=0, **looks
    )


def _save_mp4(frames: Iterable[Frame], path: Path, rate: int) -> None:
    require("mp4, unlike --video webp,", "compare", "imageio")
    import imageio.v2 as imageio

    writer: Any
    with imageio.get_writer(path, fps=rate, quality=6, macro_block_size=_CODEC_BLOCK) as writer:
        for frame in frames:
            height, width = (size // _CODEC_BLOCK * _CODEC_BLOCK for size in frame.shape[:2])
            writer.append_data(frame[:height, :width])
