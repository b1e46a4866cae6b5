"""Training LeRobot's `DiffusionPolicy` on demonstrations held in memory.

The folder of a training holds

| file | content |
|---|---|
| `policy/` | the policy with averaged weights and its processors, as LeRobot saves it |
| `training.pt` | everything that training goes on from |
| `training.json` | `TrainingConfig`: what was trained, and for how many steps |
| `loss.csv` | step, mean loss since the last line, learning rate, seconds of training |

What is compared is `policy/`. Weights are averaged (EMA) as in the published training, which
LeRobot's own trainer does not do.
"""

import csv
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np
import torch
from tqdm import tqdm

from aicon_baselines.agents.diffusion.configs import TrainingConfig
from aicon_baselines.agents.diffusion.dataset import read_frames, together
from aicon_baselines.agents.diffusion.learner import Learner
from aicon_baselines.evaluation.errors import check_counts
from aicon_baselines.files import (
    check_same_config,
    only_writer,
    read_json,
    read_text,
    replacing,
    write_json,
)

POLICY = "policy"
LOSS = "loss.csv"

_STATE = "training.pt"
_CONFIG = "training.json"

_INTERVAL = 100  # steps
_HEADER = ["step", "loss", "learning_rate", "seconds"]


def train(
    config: TrainingConfig,
    data: Path | Sequence[Path],
    folder: Path,
    device: str = "cpu",
    checkpoint: int = 1000,
    stop_after: float | None = None,
    report: Callable[[str], None] | None = None,
) -> int:
    """Train a policy, or go on with the one in the folder; saved now and then, and at the end.

    A training that was stopped gives the same policy as one that was not, on the same device.

    Args:
        config: What to train. A policy in the folder must have been trained with the same, except
            for the steps: with another number of them, the learning rate goes on along the schedule
            for that number.
        data: Folder of the dataset, or of several, the first of which normalises.
        folder: Folder of the training.
        device: "cpu" or "cuda".
        checkpoint: Steps between two saves.
        stop_after: Minutes after which to save and stop; the same call goes on later.
        report: Called with a line of text after each save.

    Returns:
        The number of steps taken.

    Raises:
        ComparisonError: Where there is no dataset, the folder holds another training, or another
            process trains there.
    """
    check_counts(checkpoint=checkpoint)
    folders = [data] if isinstance(data, Path) else data
    frames = together([read_frames(each, config.observation) for each in folders])

    with only_writer(folder):
        # 1. What has been learned before.
        _save_config(config, folder)
        learner = Learner(config, frames, torch.device(device))
        if (folder / _STATE).exists():
            learner.load(folder / _STATE)

        # 2. What is missing.
        deadline = None if stop_after is None else time.monotonic() + 60.0 * stop_after
        _learn(learner, config.steps, folder, checkpoint, deadline, report)
    return learner.step


def _learn(
    learner: Learner,
    steps: int,
    folder: Path,
    checkpoint: int,
    deadline: float | None,
    report: Callable[[str], None] | None,
) -> None:
    """Take the gradient steps that are missing, until a time of `time.monotonic` at most."""
    logger = LossLogger(folder / LOSS, learner.step)

    with tqdm(total=steps, initial=learner.step, unit="step", disable=None) as bar:
        stopped = False
        while learner.step < steps and not stopped:
            loss = learner.advance()
            logger.add(learner.step, loss, learner.learning_rate)
            bar.update()

            # Saved now and then, and before every end.
            stopped = deadline is not None and time.monotonic() > deadline
            if learner.step % checkpoint == 0 or learner.step == steps or stopped:
                learner.save(folder / _STATE, folder / POLICY)
                if report is not None:
                    report(f"step {learner.step:,} of {steps:,}: loss {logger.last:.4f}")


def _save_config(config: TrainingConfig, folder: Path) -> None:
    """Write what is trained; a folder with another training, but for the steps, is an error."""
    file, content = folder / _CONFIG, asdict(config)
    if file.exists():
        wanted = {name: value for name, value in content.items() if name != "steps"}
        check_same_config(folder, "another training", read_json(file), wanted)

    write_json(file, content)


class LossLogger:
    """Writes the loss, averaged over 100 steps, as a line of a CSV file.

    Args:
        path: The file, which may exist already.
        step: The step that training goes on from.
    """

    def __init__(self, path: Path, step: int) -> None:
        self._path = path
        self._last: float | None = None
        self._losses: list[float] = []

        # Lines after the step that training goes on from are taken again.
        lines = list(csv.reader(read_text(path).splitlines())) if path.exists() else []
        self._lines = [line for line in lines[1:] if int(line[0]) <= step]
        self._write()

        self._started = time.monotonic()
        self._seconds_before = float(self._lines[-1][3]) if self._lines else 0.0

    @property
    def last(self) -> float:
        """The loss of the line written last; before there is one, the mean so far."""
        return float(np.mean(self._losses)) if self._last is None else self._last

    def add(self, step: int, loss: float, learning_rate: float) -> None:
        """Add the loss of a step."""
        self._losses.append(loss)
        if step % _INTERVAL != 0:
            return

        self._last = float(np.mean(self._losses))
        self._losses.clear()

        seconds = self._seconds_before + time.monotonic() - self._started
        numbers = [str(step), f"{self._last:.6f}", f"{learning_rate:.3e}", f"{seconds:.1f}"]
        self._lines.append(numbers)
        self._write()

    def _write(self) -> None:
        with replacing(self._path) as place, place.open("w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows([_HEADER, *self._lines])
