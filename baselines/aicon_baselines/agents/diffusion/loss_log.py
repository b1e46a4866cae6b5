"""The loss during training, as a file."""

import csv
import time
from pathlib import Path

import numpy as np

_INTERVAL = 100  # steps


class LossLog:
    """The loss, averaged over 100 steps, as lines of a file.

    Attributes:
        last: The last line's loss.
    """

    def __init__(self, path: Path, step: int) -> None:
        """Open the file and drop what was written after the step that training goes on from."""
        self._path, self._started, self._losses = path, time.monotonic(), list[float]()
        self.last = float("nan")
        lines = list(csv.reader(path.read_text().splitlines())) if path.exists() else []
        kept = [line for line in lines[1:] if int(line[0]) <= step]
        self._before = float(kept[-1][3]) if kept else 0.0
        path.write_text(
            "\n".join(",".join(line) for line in [["step", "loss", "learning_rate", "seconds"], *kept]) + "\n"
        )

    def add(self, step: int, loss: float, learning_rate: float) -> None:
        """Add the loss of a step."""
        self._losses.append(loss)
        if step % _INTERVAL == 0:
            self.last = float(np.mean(self._losses))
            self._losses.clear()
            seconds = self._before + time.monotonic() - self._started
            with self._path.open("a") as file:
                file.write(f"{step},{self.last:.6f},{learning_rate:.3e},{seconds:.1f}\n")
