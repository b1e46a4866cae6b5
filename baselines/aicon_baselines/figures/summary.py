"""A figure's files, and what it shows in numbers and in words."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from aicon_baselines.evaluation.errors import check_known
from aicon_baselines.figures.rendering import VIDEO_FORMATS
from aicon_baselines.files import write_json


@dataclass(frozen=True)
class FigureSummary:
    """What a figure shows and where it was saved; `print` says both.

    Attributes:
        headline: How the episode ended, in one line.
        numbers: The figure's numbers, which are in its JSON file.
        files: What was saved.
    """

    headline: str
    numbers: dict[str, Any]
    files: tuple[Path, ...]

    def __str__(self) -> str:
        """The headline, a line for each panel, and the files."""
        lines = [self.headline]
        for panel in self.numbers.get("panels", []):
            lines.append(f"  ({panel['panel']}) {panel['time_s']:6.2f} s  {panel['title']}")

        names = ", ".join(path.name for path in self.files)
        lines.append(f"saved in {self.files[0].parent}: {names}")
        return "\n".join(lines)


class FigureFiles:
    """Where a figure's picture, film and numbers are saved.

    Args:
        out: Folder, made if it does not exist.
        name: Of the files, without an ending.
        video: Format of the film, one of `VIDEO_FORMATS`; an unknown one is a ComparisonError.
    """

    def __init__(self, out: Path, name: str, video: str) -> None:
        check_known("video", video, VIDEO_FORMATS)
        out.mkdir(parents=True, exist_ok=True)
        self.picture, self.numbers = out / f"{name}.png", out / f"{name}.json"
        self.film = None if video == "none" else out / f"{name}.{video}"

    def summary(self, headline: str, numbers: dict[str, Any]) -> FigureSummary:
        """Save the numbers; return what was saved, and what it shows."""
        write_json(self.numbers, numbers)
        saved = (self.picture, self.numbers, self.film)
        return FigureSummary(headline, numbers, tuple(path for path in saved if path is not None))
