"""The loss during training, as a file."""

import csv
import time
from pathlib import Path

import numpy as np

from aicon_baselines.files import read_text, replacing

_INTERVAL = 100  # steps
_HEADER = ["step", "loss", "learning_rate", "seconds"]


class LossLogger:
    """Writes the loss, averaged over 100 steps, as a line of a CSV file.

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

        # Lines after the step that training goes on from are taken again.
        lines = list(csv.reader(read_text(path).splitlines())) if path.exists() else []
        self._lines = [line for line in lines[1:] if int(line[0]) <= step]
        self._write()

        self._started = time.monotonic()
        self._seconds_before = float(self._lines[-1][3]) if self._lines else 0.0

    def add(self, step: int, loss: float, learning_rate: float) -> None:
        """Add the loss of a step."""
        self._losses.append(loss)
        if step % _INTERVAL != 0:
            return

        self.last = float(np.mean(self._losses))
        self._losses.clear()

        seconds = self._seconds_before + time.monotonic() - self._started
        numbers = [str(step), f"{self.last:.6f}", f"{learning_rate:.3e}", f"{seconds:.1f}"]
        self._lines.append(numbers)
        self._write()

    def _write(self) -> None:
        with replacing(self._path) as place, place.open("w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows([_HEADER, *self._lines])
