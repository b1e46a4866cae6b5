import json
import math
import re
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("stable_baselines3")
pytest.importorskip("pymunk")

from aicon_baselines.agents import sb3
from aicon_baselines.agents.sb3.environments import make_training_envs
from aicon_baselines.agents.sb3.replay_file import load_replay_buffer
from aicon_baselines.agents.sb3.statistics import load_statistics
from aicon_baselines.agents.sb3.weights import load_algorithm
from aicon_baselines.agents.sb3.wrappers import LAST_ACTION
from aicon_baselines.evaluation import ComparisonError


def read_steps(folder: Path) -> int:
    steps: int = json.loads((folder / "config.json").read_text())["steps"]
    return steps


def test_training_goes_on_where_it_was_saved(
    kind: tuple[str, str],
    agent_folders: dict[tuple[str, str], Path],
    small: dict[str, Any],
    tmp_path: Path,
) -> None:
    folder = shutil.copytree(agent_folders[kind], tmp_path / "agent")
    before = read_steps(folder)
    config = sb3.TrainingConfig.for_task(*kind, before + 20, **small)
    lines: list[str] = []

    after = sb3.train(config, folder, checkpoint=10, report=lines.append).steps

    assert before + 20 <= after == read_steps(folder)
    assert lines and (folder / f"log_{before}" / "progress.csv").exists()
    assert not list(folder.glob(".new-*"))
    assert sb3.train(config, folder).steps == after  # nothing is missing


def test_an_agent_whose_saving_is_killed_is_the_one_of_before(
    agent_folders: dict[tuple[str, str], Path],
    small: dict[str, Any],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    folder = shutil.copytree(agent_folders["pusht", "ppo"], tmp_path / "agent")
    before = {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}
    config = sb3.TrainingConfig.for_task("pusht", "ppo", read_steps(folder) + 20, **small)

    def kill(*_: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("aicon_baselines.agents.sb3.agent_folder.save_statistics", kill)
    with pytest.raises(KeyboardInterrupt):
        sb3.train(config, folder)
    assert before == {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


def test_another_agent_is_not_overwritten(
    kind: tuple[str, str], agent_folders: dict[tuple[str, str], Path], small: dict[str, Any]
) -> None:
    config = sb3.TrainingConfig.for_task(*kind, 1000, seed=10_001, **small)
    with pytest.raises(ComparisonError, match=r"another agent: seed is 10000 there and 10001 here"):
        sb3.train(config, agent_folders[kind])


def test_sac_learns_from_what_it_saw(
    agent_folders: dict[tuple[str, str], Path], small: dict[str, Any]
) -> None:
    """Each reading of the buffer is a stack, and the next observation is one reading newer."""
    folder = agent_folders["nav2d", "sac"]
    config = sb3.TrainingConfig.for_task("nav2d", "sac", 60, **small)
    envs = load_statistics(folder / "statistics.json", make_training_envs(config, 0), 0.99)
    model: Any = load_algorithm(folder / "agent.zip", config, envs)
    load_replay_buffer(folder / "replay_buffer.npz", model)
    buffer = model.replay_buffer
    count = buffer.size()

    for name, width in {"range": 1, "bearing": 1, LAST_ACTION: 2}.items():
        stacks = buffer.observations[name][:count]
        next_stacks = buffer.next_observations[name][:count]
        assert np.array_equal(next_stacks[..., :-width], stacks[..., width:])
        assert len(np.unique(next_stacks[10])) == next_stacks[10].size

    last_actions = buffer.next_observations[LAST_ACTION][:count, :, -2:]
    assert np.array_equal(last_actions, buffer.actions[:count])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"task": "pushx"}, "unknown task 'pushx'; valid tasks: nav2d, pusht"),
        ({"task": "arm_push"}, "unknown task 'arm_push'; valid tasks: nav2d, pusht"),
        ({"algorithm": "dqn"}, "unknown algorithm 'dqn'; valid algorithms: ppo, sac"),
        ({"steps": 0}, "steps must be 1 or more, not 0"),
        ({"discount": math.nan}, "discount must be in (0, 1], not nan"),
        ({"reach": math.nan}, "reach must be positive, or None, not nan"),
        ({"approach": -0.1}, "approach must be 0 or more, not -0.1"),
        ({"seed": 3}, "the seed must be 1000 or more, not 3"),
    ],
)
def test_a_training_that_makes_no_sense_is_an_error(
    arguments: dict[str, Any], message: str
) -> None:
    usual: dict[str, Any] = {"task": "pusht", "algorithm": "ppo", "steps": 10}
    with pytest.raises(ComparisonError, match=re.escape(message)):
        sb3.TrainingConfig.for_task(**usual | arguments)
