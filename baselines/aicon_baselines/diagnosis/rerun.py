"""An episode of a comparison, run again and recorded."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import torch

from aicon_baselines.agents.registry import compiled, factory, own_policy
from aicon_baselines.diagnosis.history import History
from aicon_baselines.evaluation.config import Config
from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.evaluation.recording import FloatArray, Recording, record
from aicon_baselines.evaluation.row import Row
from aicon_baselines.evaluation.run_folder import RunFolder
from aicon_baselines.evaluation.task import Task
from aicon_baselines.tasks import load
from aicon_baselines.worlds import Shape, surroundings
from aicon_torch import Policy


@dataclass(frozen=True)
class Rerun:
    """An episode that was run again; `str` says which it was, and how it ended.

    Attributes:
        task: Its task.
        row: What the comparison had of it.
        recording: What happened now.
    """

    task: Task
    row: Row
    recording: Recording

    def __str__(self) -> str:
        """The episode and its ending, in a line."""
        row, recording = self.row, self.recording
        ending = "success" if recording.success else "no success"
        return (
            f"seed {row.seed}, {row.policy}, {row.condition}: {ending} after {recording.steps} "
            f"steps ({recording.steps * recording.time_step:g} s), "
            f"{recording.infos[-1]['distance']:.3g} {self.task.length_unit} from the target"
        )

    @cached_property
    def history(self) -> History:
        """What happened, as curves."""
        return History.of(self.recording)

    @property
    def places(self) -> FloatArray:
        """Where the robot was, (n, 2 or 3), in the task's unit."""
        return self.recording.told("position")[:-1]

    @property
    def around(self) -> dict[str, Shape]:
        """What lay around the robot at the end."""
        return surroundings(self.task.name, self.recording.env, self.recording.infos[-1])

    @property
    def flipped(self) -> bool:
        """Whether y points down, as it does where lengths are pixels."""
        return self.task.length_unit == "px"


def choose_row(
    rows: list[Row], seed: int, policy: str | None = None, condition: str | None = None
) -> Row:
    """The row of a seed: of those that fit, the first that failed, or else the first.

    Raises:
        ComparisonError: If there is none.
    """
    fitting = [
        row
        for row in rows
        if row.seed == seed and policy in (None, row.policy) and condition in (None, row.condition)
    ]
    if not fitting:
        raise ComparisonError(
            f"there is no such episode; policies: {_names(rows, 'policy')}; conditions: "
            f"{_names(rows, 'condition')}; seeds: {min(row.seed for row in rows)} to "
            f"{max(row.seed for row in rows)}"
        )
    failed = [row for row in fitting if not row.success]
    return (failed or fitting)[0]


def rerun(
    folder: Path, seed: int, policy: str | None = None, condition: str | None = None
) -> Rerun:
    """Run an episode of a comparison again, alone and compiled, and record it.

    Args:
        folder: The comparison's folder.
        seed: Seed of the episode.
        policy: Its policy, as the rows call it; by default one that failed.
        condition: Its condition; likewise.

    Raises:
        ComparisonError: If the folder holds no such episode, its policy keeps no memory that tells
            what it decided, or it ended with its first step.
    """
    config = Config.load(folder / "config.json")
    rows = RunFolder(folder, config).rows()
    if not rows:
        raise ComparisonError(f"{folder} holds no episodes yet: run aicon compare")

    row = choose_row(rows, seed, policy, condition)
    task = config.apply(load(config.task))
    build = own_policy(row.policy) if ":" in row.policy else factory(task.name, row.policy)
    built: Any = compiled(build)(row.condition)
    if not isinstance(built, Policy):
        raise ComparisonError(f"{row.policy} is no policy of the library: it keeps no trace")

    torch.set_num_threads(1)
    env = task.make_env(1, row.condition, task.horizon)
    reset = task.reset_arguments([task.episode(row.seed, row.repeat)])
    recording = record(Recording, built, env, reset, task.horizon)
    if recording.steps < 2:
        raise ComparisonError(f"seed {row.seed} ended with its first step: nothing is seen in it")
    return Rerun(task, row, recording)


def _names(rows: list[Row], field: str) -> str:
    return ", ".join(sorted({getattr(row, field) for row in rows}))
