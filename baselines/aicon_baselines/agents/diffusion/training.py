"""Training LeRobot's `DiffusionPolicy` on demonstrations held in memory.

The folder of a training holds

| file | content |
|---|---|
| `policy/` | the policy with averaged weights and its processors, as LeRobot saves it: what is compared |
| `training.pt` | everything that training goes on from |
| `training.json` | `Training`: what was trained, and for how many steps |
| `loss.csv` | step, mean loss since the last line, learning rate, seconds of training |

Weights are averaged (EMA) as in the published training, which LeRobot's own trainer does not do.
"""

import json
import time
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

import torch
from tqdm import tqdm

from aicon_baselines.agents.diffusion.dataset import read
from aicon_baselines.agents.diffusion.learner import Learner
from aicon_baselines.agents.diffusion.loss_log import LossLog
from aicon_baselines.agents.diffusion.settings import Training
from aicon_baselines.evaluation.errors import ComparisonError

POLICY, _STATE, _SETTINGS, _LOSS = "policy", "training.pt", "training.json", "loss.csv"


def train(
    config: Training,
    data: Path,
    folder: Path,
    device: str = "cpu",
    checkpoint: int = 1000,
    stop_after: float | None = None,
    report: Callable[[str], None] = lambda line: None,
) -> int:
    """Train a policy, or go on with the one in the folder, and save it every `checkpoint` steps and at the end.

    A training that was stopped gives the same policy as one that was not, on the same device.

    Args:
        config: What to train. A policy in the folder must have been trained with the same settings, except for the
            steps: with another number of them, the learning rate goes on along the schedule for that number.
        data: Folder of the dataset.
        folder: Folder of the training.
        device: "cpu" or "cuda".
        checkpoint: Steps between two saves.
        stop_after: Minutes after which to save and stop; the same call goes on later.
        report: Called with a line of text after each save.

    Returns:
        The number of steps taken.
    """
    if checkpoint < 1:
        raise ComparisonError(f"checkpoint must be 1 or more, not {checkpoint}")
    frames = read(data, config.observation)
    folder.mkdir(parents=True, exist_ok=True)
    _check_settings(config, folder / _SETTINGS)
    learner = Learner(config, frames, torch.device(device))
    if (folder / _STATE).exists():
        learner.load(folder / _STATE)
    log = LossLog(folder / _LOSS, learner.step)
    started = time.monotonic()
    with tqdm(total=config.steps, initial=learner.step, unit="step", disable=None) as bar:
        while learner.step < config.steps:
            log.add(learner.step + 1, learner.advance(), learner.learning_rate)
            bar.update()
            late = stop_after is not None and time.monotonic() - started > 60.0 * stop_after
            if learner.step % checkpoint == 0 or learner.step == config.steps or late:
                learner.save(folder / _STATE, folder / POLICY)
                report(f"step {learner.step:,} of {config.steps:,}: loss {log.last:.4f}")
            if late:
                break
    return learner.step


def _check_settings(config: Training, file: Path) -> None:
    here = json.loads(json.dumps(asdict(config)))
    there = json.loads(file.read_text()) if file.exists() else here
    differing = [name for name in here if name != "steps" and there.get(name) != here[name]]
    if differing:
        details = "; ".join(f"{name} is {there.get(name)} there and {here[name]} here" for name in differing)
        raise ComparisonError(f"{file.parent} holds another training: {details}. Choose another folder.")
    file.write_text(json.dumps(here, indent=2) + "\n")
