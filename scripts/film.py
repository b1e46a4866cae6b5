"""What films of arms share: panels beside each other, with words in them."""

from collections.abc import Iterator, Sequence

import numpy as np
from PIL import Image, ImageDraw

from aicon_baselines.figures.rendering import Frame


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
