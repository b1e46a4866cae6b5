"""The task "nav2d"."""

from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from _inputs.shipped import quick
from numpy.typing import NDArray

from aicon_baselines.agents import make
from aicon_baselines.evaluation.comparison import compare
from aicon_baselines.evaluation.config import configure
from aicon_baselines.evaluation.rollout import rollout
from aicon_baselines.evaluation.run_folder import RunFolder
from aicon_baselines.tasks.nav2d import TASK
from aicon_envs.nav2d import MAP_NAMES, Nav2DVectorEnv, shortest_path_length


def test_seeds_choose_every_class_and_mazes_twice() -> None:
    counts = Counter(episode.map for episode in TASK.chunk(0, repeat=0)[:17])
    assert set(counts) == set(MAP_NAMES)
    assert [name for name, count in counts.items() if count > 1] == ["maze"]

    first, again = TASK.chunk(2, repeat=0)[5], TASK.chunk(2, repeat=1)[5]
    assert (first.seed, first.map) == (again.seed, again.map) == (261, TASK.maps[261 % 17])
    assert first.noise_seed != again.noise_seed


def test_shortest_paths_are_those_of_the_environment() -> None:
    episodes = TASK.chunk(0, repeat=0)[:17]
    env = TASK.make_env(len(episodes), "range", 5)
    assert isinstance(env, Nav2DVectorEnv) and TASK.shortest_path_length is not None
    env.reset(**TASK.reset_arguments(episodes))

    for episode, (name, obstacles, start, target) in zip(episodes, env.maps, strict=True):
        assert name == episode.map
        length = shortest_path_length(obstacles, start, target, env.physics.radius)
        assert TASK.shortest_path_length(episode) == length


class TowardBearing:
    """Walks toward the target at 0.5 m/s."""

    def predict(
        self,
        observation: dict[str, NDArray[Any]],
        state: Any = None,
        episode_start: NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[Any, Any]:
        """Choose the velocity."""
        bearing = observation["bearing"]
        return 0.5 * np.concatenate([np.cos(bearing), np.sin(bearing)], axis=-1), None


def test_walking_straight_at_the_target(tmp_path: Path) -> None:
    task = replace(TASK, chunk_size=16)
    config = configure(task, episodes=8, maps=["ring_outside", "clutter"], horizon=800)
    with RunFolder.open(tmp_path, config) as folder:
        compare(task, {"straight": lambda condition: TowardBearing()}, folder)
        rows = folder.rows()

    assert all(row.success or row.collision for row in rows)
    assert any(row.collision for row in rows)
    for row in rows:
        assert row.distance < 0.2 or row.collision
        assert not row.success or row.path_length > (row.shortest_path_length or 0) - 0.2


@pytest.mark.slow
def test_aicon_escapes_where_the_others_stay() -> None:
    seeds = range(2040, 2074)
    episodes = [TASK.episode(seed) for seed in seeds]
    success = {}
    for name in ("aicon", "paper_literal", "steepest", "potential_field"):
        policy = quick(make("nav2d", name))
        outcome = rollout(policy, TASK, "range", episodes, seeds)
        success[name] = float(outcome.success.mean())

    stay = max(success["steepest"], success["potential_field"])
    assert success["aicon"] >= 0.97
    assert success["aicon"] > success["paper_literal"] > stay
