"""What films share: where they are saved, panels beside each other, and words in them."""

import argparse
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from aicon_baselines.cli.command_line import add_option
from aicon_baselines.figures.rendering import Frame, save_video


def add_film(parser: argparse.ArgumentParser, path: str) -> None:
    """Declare `--out`, where a film is saved."""
    add_option(parser, "--out", Path(path), "the film, a webp or an mp4", type=_film)


def _film(text: str) -> Path:
    """The path of a film, refused before anything is filmed where it has another ending."""
    path = Path(text)
    if path.suffix not in (".webp", ".mp4"):
        raise argparse.ArgumentTypeError(f"a film ends in .webp or .mp4, not {path.suffix!r}")
    return path


def save_film(frames: Iterable[Frame], path: Path, interval: float) -> None:
    """Save frames, one in so many seconds, and say where."""
    save_video(frames, path, round(1.0 / interval))
    print(f"saved {path}")


def beside_each_other(films: Sequence[Sequence[Frame]], stays: int) -> Iterator[Frame]:
    """Frames with a panel for each film; one that is over stands still, and so do all in the end.

    Args:
        films: The frames of each.
        stays: How many frames of the end there are besides.
    """
    for number in range(max(map(len, films)) + stays):
        yield np.concatenate([film[min(number, len(film) - 1)] for film in films], axis=1)


def labelled(picture: Frame, name: str, told: str, colour: str) -> Frame:
    """A picture with its name, and what is told of it in a colour."""
    image = Image.fromarray(picture)
    drawn = ImageDraw.Draw(image)
    drawn.text((10, 8), name, fill="black", font_size=18)
    drawn.text((10, 30), told, fill=colour, font_size=15)
    return np.asarray(image)
