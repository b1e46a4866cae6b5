"""Small agents of both tasks and both algorithms, trained once for all tests of a process."""

from pathlib import Path
from typing import Any

import pytest

KINDS = [("nav2d", "ppo"), ("nav2d", "sac"), ("pusht", "ppo"), ("pusht", "sac")]
QUICK = KINDS[0], KINDS[3]
"""With the quick tests each task and each algorithm is there once."""

STEPS = {"ppo": 256, "sac": 60}


@pytest.fixture(scope="session")
def small() -> dict[str, int]:
    """Options of a training that takes a second."""
    return {"envs": 2, "rollout": 64, "horizon": 40}


@pytest.fixture(scope="session")
def agent_folders(
    small: dict[str, Any], tmp_path_factory: pytest.TempPathFactory
) -> dict[tuple[str, str], Path]:
    """The folder of each agent, by task and algorithm."""
    from aicon_baselines.agents import sb3

    root = tmp_path_factory.mktemp("agents")
    folders = {}
    for task, algorithm in KINDS:
        folder = root / f"{task}_{algorithm}"
        config = sb3.TrainingConfig.for_task(task, algorithm, STEPS[algorithm], **small)
        sb3.train(config, folder, checkpoint=100)
        folders[task, algorithm] = folder

    return folders


@pytest.fixture(
    params=[pytest.param(kind, marks=[pytest.mark.slow] * (kind not in QUICK)) for kind in KINDS],
    ids="-".join,
)
def kind(request: pytest.FixtureRequest) -> tuple[str, str]:
    """A task and an algorithm."""
    kind: tuple[str, str] = request.param
    return kind
