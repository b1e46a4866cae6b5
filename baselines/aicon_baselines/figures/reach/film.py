"""The film: an arm with a ball in its way, and what it does about it."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from aicon_baselines.figures.reach.picture import ZOOM
from aicon_baselines.figures.reach.recording import STRIDE, ReachRecording
from aicon_baselines.figures.rendering import EVEN_PALETTE, Frame, is_moving_picture, save_video
from aicon_baselines.palette import EXPLORING, INK
from aicon_envs.reach.simulation import CONTROL_STEP

_RATE = 25  # pictures a second, as they are recorded
_REST = 15  # pictures that the last one stands
_SIDE = 320  # of a moving picture, px


def draw_film(recording: ReachRecording, path: Path) -> None:
    """Save an episode as a video, mp4, webp or gif by the name of the file.

    A moving picture has every second frame, and is smaller; the last frame rests.
    """
    small = is_moving_picture(path)
    stride, rate = (2, _RATE // 2) if small else (1, _RATE)
    frames = list(captioned(recording, stride))
    frames += frames[-1:] * (_REST // stride)

    if small:
        frames = [_scaled(frame) for frame in frames]
    save_video(frames, path, rate, EVEN_PALETTE)


def captioned(recording: ReachRecording, stride: int = 1) -> Iterator[Frame]:
    """The pictures of an episode, each with its time and what the policy does.

    Args:
        recording: The episode.
        stride: Which of its pictures: every one, every second one, ….
    """
    last = len(recording.frames) - 1
    for number in (*range(0, last, stride), last):
        step = min(number * STRIDE, len(recording.times))
        explores = step > 0 and bool(recording.exploring[step - 1])
        doing = "held up: exploring" if explores else "descending"
        if number == last:
            doing = "arrived" if recording.success else "did not arrive"

        picture = Image.fromarray(recording.frames[number][ZOOM, ZOOM])
        words = f"{recording.robot}   {step * CONTROL_STEP:.1f} s   {doing}"
        color = EXPLORING if explores and number < last else INK
        ImageDraw.Draw(picture).text((12, 8), words, fill=color, font_size=21)
        yield np.asarray(picture)


def _scaled(frame: Frame) -> Frame:
    """A frame as large as moving pictures are."""
    return np.asarray(Image.fromarray(frame).resize((_SIDE, _SIDE), Image.Resampling.LANCZOS))
