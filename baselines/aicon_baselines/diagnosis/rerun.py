"""An episode of a comparison, run again and recorded."""

from contextlib import closing
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import torch

from aicon_baselines.agents.registry import compiled, factory, own_policy
from aicon_baselines.diagnosis.history import History
from aicon_baselines.evaluation.config import Config
from aicon_baselines.evaluation.episodes import run_episodes
from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.evaluation.predictor import Factory
from aicon_baselines.evaluation.recording import FloatArray, Recording
from aicon_baselines.evaluation.row import Row
from aicon_baselines.evaluation.run_folder import RunFolder
from aicon_baselines.evaluation.task import Task
from aicon_baselines.tasks import load
from aicon_baselines.worlds import Shape, surroundings
from aicon_torch import Policy
from aicon_torch.resolution import Memory


@dataclass(frozen=True)
class Rerun:
    """An episode that was run again.

    Attributes:
        row: What the comparison had of it.
        history: What happened now.
        places: Where the robot was, (n, 2 or 3), in `unit`.
        distance: To the target at the end, in `unit`.
        unit: Unit of the lengths.
        around: What lay around the robot at the end.
    """

    row: Row
    history: History
    places: FloatArray
    distance: float
    unit: str
    around: dict[str, Shape]

    @property
    def flipped(self) -> bool:
        """Whether y points down, as it does where lengths are pixels."""
        return self.unit == "px"


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
        ComparisonError: If the folder holds no such episode, or its policy keeps no memory that
            tells what it decided.
    """
    config = Config.load(folder / "config.json")
    rows = RunFolder(folder, config).rows()
    if not rows:
        raise ComparisonError(f"{folder} holds no episodes yet: run aicon compare")

    row = choose_row(rows, seed, policy, condition)
    task = config.apply(load(config.task))
    built: Any = compiled(_factory(task, row.policy))(row.condition)
    if not isinstance(built, Policy):
        raise ComparisonError(f"{row.policy} is no policy of the library: it keeps no trace")
    return _record(task, row, built)


def describe(again: Rerun) -> str:
    """Which episode it was, and how it ended."""
    row, history = again.row, again.history
    ending = "success" if history.success else "no success"
    return (
        f"seed {row.seed}, {row.policy}, {row.condition}: {ending} after "
        f"{history.steps} steps ({history.steps * history.dt:g} s), {again.distance:.3g} "
        f"{again.unit} from the target"
    )


def _factory(task: Task, name: str) -> Factory:
    """What builds the policy of a row."""
    if ":" in name:
        return own_policy(name)
    return factory(task.name, name)


def _record(task: Task, row: Row, policy: Policy) -> Rerun:
    """Run the episode of a row."""
    torch.set_num_threads(1)
    memories: list[Memory] = []
    places: list[FloatArray] = []

    with closing(task.make_env(1, row.condition, task.horizon)) as env:
        start = env.reset(**task.reset_arguments([task.episode(row.seed, row.repeat)]))
        for step in islice(run_episodes(policy, env, start), task.horizon):
            memories.append(step.memory)
            places.append(np.array(step.before["position"][0], dtype=np.float64))
        around = surroundings(task.name, env, step.next_observation, step.info)

    history = History.of(Recording(policy, memories, bool(step.info["is_success"][0])))
    distance = float(step.info["distance"][0])
    return Rerun(row, history, np.array(places), distance, task.length_unit, around)


def _names(rows: list[Row], field: str) -> str:
    return ", ".join(sorted({getattr(row, field) for row in rows}))
