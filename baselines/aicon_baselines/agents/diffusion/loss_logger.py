"""The loss during training, as a file."""

import csv
import time
from pathlib import Path

import numpy as np

from aicon_baselines.files import replacing

_INTERVAL = 100  # steps
_HEADER = ["step", "loss", "learning_rate", "seconds"]


class LossLogger:
    """Writes the loss, averaged over 100 steps, as a line of a CSV file.

    Lines after the step that training goes on from are dropped.

    Args:
        path: The file, which may exist already.
        step: The step that training goes on from.

    Attributes:
        last: The loss of the line written last.
    """

    def __init__(self, path: Path, step: int) -> None:
        self.last = float("nan")
        self._path = path
        self._losses: list[float] = []

        kept = _read_lines(path, step)
        with replacing(path) as place:
            _write_lines(place, [_HEADER, *kept], mode="w")

        self._started = time.monotonic()
        self._seconds_before = float(kept[-1][3]) if kept else 0.0

    def add(self, step: int, loss: float, learning_rate: float) -> None:
        """Add the loss of a step."""
        self._losses.append(loss)
        if step % _INTERVAL != 0:
            return

        self.last = float(np.mean(self._losses))
        self._losses.clear()

        seconds = self._seconds_before + time.monotonic() - self._started
        line = [str(step), f"{self.last:.6f}", f"{learning_rate:.3e}", f"{seconds:.1f}"]
        _write_lines(self._path, [line], mode="a")


def _read_lines(path: Path, last_step: int) -> list[list[str]]:
    """Read the lines up to a step, without the header."""
    if not path.exists():
        return []

    with path.open(newline="") as file:
        lines = list(csv.reader(file))
    # A kill may have torn the last line.
    whole = [line for line in lines[1:] if len(line) == len(_HEADER)]
    return [line for line in whole if int(line[0]) <= last_step]


def _write_lines(path: Path, lines: list[list[str]], mode: str) -> None:
    with path.open(mode, newline="") as file:
        csv.writer(file, lineterminator="\n").writerows(lines)
