"""The six pictures, one file each."""

from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType

from aicon_baselines.figures.concepts import (
    conflict,
    exploration,
    foresight,
    meeting,
    path,
    projection,
)
from aicon_baselines.figures.summary import FigureSummary

PICTURES: Mapping[str, Callable[[Path], None]] = MappingProxyType(
    {
        "path": path.draw,
        "meeting": meeting.draw,
        "projection": projection.draw,
        "conflict": conflict.draw,
        "exploration": exploration.draw,
        "foresight": foresight.draw,
    }
)
"""What draws each picture."""


def make_figure(out: Path) -> FigureSummary:
    """Draw the six pictures.

    Args:
        out: Folder, made if it does not exist.
    """
    out.mkdir(parents=True, exist_ok=True)
    files = []
    for name, draw in PICTURES.items():
        files.append(out / f"concept_{name}.png")
        draw(files[-1])
    return FigureSummary("The idea in six pictures", {}, tuple(files))
