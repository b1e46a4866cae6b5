"""Demonstrations, a policy trained on them, and what robots observe; made once for each process."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

Observation = dict[str, np.ndarray]


@pytest.fixture(scope="session")
def quick() -> dict[str, Any]:
    """Options of a recording of short episodes."""
    return {"episodes": 3, "max_speed": 800.0, "smoothing": 0.02}


@pytest.fixture(scope="session")
def small() -> dict[str, Any]:
    """Options of a training that takes a second."""
    return {"down_dims": (8, 16), "batch": 8}


@pytest.fixture(scope="session")
def chunks_of() -> Callable[[pytest.MonkeyPatch, int], None]:
    """Makes chunks of demonstrations smaller."""
    from aicon_baselines.agents.diffusion import collection, demonstrations

    def set_size(patch: pytest.MonkeyPatch, size: int) -> None:
        patch.setattr(demonstrations, "CHUNK_SIZE", size)
        patch.setattr(collection, "CHUNK_SIZE", size)

    return set_size


@pytest.fixture(scope="session")
def demos(
    quick: dict[str, Any],
    chunks_of: Callable[[pytest.MonkeyPatch, int], None],
    tmp_path_factory: pytest.TempPathFactory,
) -> Path:
    """The folder of a dataset with keypoints and pictures."""
    from aicon_baselines.agents.diffusion.collection import collect
    from aicon_baselines.agents.diffusion.configs import RecordingConfig

    folder = tmp_path_factory.mktemp("demos") / "data"
    with pytest.MonkeyPatch.context() as patch:
        chunks_of(patch, 2)
        collect(RecordingConfig(**quick, observations=("keypoints", "pixels")), folder)

    return folder


@pytest.fixture(scope="session")
def policy(demos: Path, small: dict[str, Any], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a trained policy."""
    from aicon_baselines.agents.diffusion.configs import TrainingConfig
    from aicon_baselines.agents.diffusion.training import train

    folder = tmp_path_factory.mktemp("training")
    assert train(TrainingConfig(20, **small), demos, folder, checkpoint=20) == 20
    return folder / "policy"


@pytest.fixture(scope="session")
def observations() -> list[Observation]:
    """What 4 robots see in 12 steps."""
    rng = np.random.default_rng(0)
    observations = []
    for _ in range(12):
        keypoints, pusher = rng.uniform(100, 400, (4, 16)), rng.uniform(100, 400, (4, 2))
        observations.append({"environment_state": keypoints, "agent_pos": pusher})

    return observations


@pytest.fixture(scope="session")
def act() -> Callable[..., np.ndarray]:
    """Asks an agent for the actions (T, B, 2) of successive observations."""

    def run(
        agent: Any, observations: list[Observation], starts: dict[int, list[int]] | None = None
    ) -> np.ndarray:
        """`starts` lists the rows whose episode begins, by step."""
        memory, actions = None, []
        for t, observation in enumerate(observations):
            rows = np.arange(len(observation["agent_pos"]))
            start = np.isin(rows, (starts or {}).get(t, []))
            action, memory = agent.predict(observation, memory, start)
            actions.append(action)
        return np.stack(actions)

    return run
