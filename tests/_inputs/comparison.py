"""What comparisons are tested on: a task of walking points, two walkers, and rows made by hand."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from numpy.typing import NDArray

from aicon_baselines.evaluation import Factory
from aicon_baselines.evaluation.comparison import compare
from aicon_baselines.evaluation.config import Config, configure
from aicon_baselines.evaluation.row import Row
from aicon_baselines.evaluation.run_folder import RunFolder
from aicon_baselines.evaluation.task import Episode, Task

TARGET = np.array([3.0, 0.0])  # m
WALL = 1.5  # m; touching y = WALL is a collision


class PointEnv(VectorEnv[Any, Any, Any]):
    """Points that walk from the origin to TARGET below a wall, with noise of 0.1 m a step."""

    metadata = {"autoreset_mode": AutoresetMode.DISABLED}

    def __init__(self, num_envs: int) -> None:
        self.num_envs = num_envs

    def reset(
        self, *, seed: Any = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Put the points at the origin; those on a windy map have twice the noise."""
        self.generators = [np.random.default_rng(own) for own in seed]
        scales = [2.0 if name == "windy" else 1.0 for name in (options or {})["map"]]
        self.scale = np.array(scales)[:, None]
        self.position = np.zeros((self.num_envs, 2))
        return self._observe()

    def step(self, actions: NDArray[np.float64]) -> Any:
        """Move those that have not ended."""
        noise = np.stack([generator.normal(0.0, 0.1, 2) for generator in self.generators])
        ended = self.success | self.collision
        moved = self.position + 0.1 * actions + self.scale * noise
        self.position = np.where(ended[:, None], self.position, moved)

        observation, info = self._observe()
        terminated, truncated = self.success | self.collision, np.zeros(self.num_envs, bool)
        return observation, np.zeros(self.num_envs), terminated, truncated, info

    def _observe(self) -> tuple[dict[str, NDArray[np.float64]], dict[str, Any]]:
        distance = np.linalg.norm(TARGET - self.position, axis=-1)
        self.collision = self.position[:, 1] > WALL
        self.success = (distance < 0.2) & ~self.collision
        info = {
            "is_success": self.success,
            "collision": self.collision,
            "distance": distance,
            "position": self.position,
        }
        return {"target": TARGET - self.position}, info


class Walker:
    """Walks to the target at a speed (m/s) that grows with the number of steps it remembers."""

    def __init__(self, speed: float) -> None:
        self.speed = speed

    def predict(
        self,
        observation: dict[str, NDArray[Any]],
        state: Any = None,
        episode_start: NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[Any, Any]:
        """Walk toward the target, and remember one step more."""
        assert episode_start is not None
        age = np.where(episode_start, 0, 0 if state is None else state)
        target = observation["target"]
        direction = target / np.linalg.norm(target, axis=-1, keepdims=True)

        # The mean over the batch stands for what batched arithmetic does to the last bits, only
        # larger.
        velocity = self.speed * (1 + 0.01 * age[:, None]) * direction
        return velocity + 0.01 * target.mean(axis=0), age + 1


def _make_env(count: int, condition: str, horizon: int) -> VectorEnv[Any, Any, Any]:
    return PointEnv(count)


def _reset_arguments(episodes: Sequence[Episode]) -> dict[str, Any]:
    options = {"map": [episode.map for episode in episodes]}
    return {"seed": [episode.noise_seed for episode in episodes], "options": options}


def _policy_options(condition: str) -> dict[str, Any]:
    return {}


def _distance_to_target(episode: Episode) -> float:
    return 2.8


POINTS = Task(
    name="points",
    time_step=0.1,
    horizon=40,
    chunk_size=8,
    maps=("calm", "windy", "calm"),
    conditions=("usual", "other"),
    make_env=_make_env,
    reset_arguments=_reset_arguments,
    policy_options=_policy_options,
    shortest_path_length=_distance_to_target,
)
"""The task of the walking points; time in seconds."""

STEPS = replace(
    POINTS,
    horizon=400,
    time_unit="steps",
    length_unit="px",
    milestones=(99, 100, 300),
    shortest_path_length=None,
)
"""The same with time in steps, milestones, and no shortest path."""


def slow(condition: str) -> Walker:
    """Build a walker of 0.7 m/s."""
    return Walker(0.7)


def fast(condition: str) -> Walker:
    """Build a walker of 2 m/s."""
    return Walker(2.0)


WALKERS: dict[str, Factory] = {"slow": slow, "fast": fast}


def compare_walkers(
    path: Path,
    config: Config | None = None,
    policies: Sequence[str] = ("slow", "fast"),
    **options: Any,
) -> bytes:
    """Run a comparison of walkers and return its file of episodes."""
    config = config or configure(POINTS, seed=3, episodes=16, repeats=2)
    with RunFolder.open(path, config) as folder:
        compare(POINTS, {name: WALKERS[name] for name in policies}, folder, **options)
    return (path / "episodes.csv").read_bytes()


def handmade_rows() -> list[Row]:
    """Four episodes of policy "a", one of which collides, and one of "b", which fails."""
    return [
        _row("a", 0, "u", steps=100, path_length=2.0),
        _row("a", 1, "v", steps=300, path_length=6.0),
        _row("a", 2, "u", steps=None, path_length=9.0, collision=True),
        _row("a", 3, "v", steps=100, path_length=3.0),
        _row("b", 0, "u", steps=None, path_length=9.0),
    ]


def rows_by_steps(policy: str, steps: Sequence[int | None]) -> list[Row]:
    """An episode of a policy for each number of steps to success; None for a failure."""
    return [_row(policy, seed, "maze", each, 1.0) for seed, each in enumerate(steps)]


def _row(
    policy: str,
    seed: int,
    name: str,
    steps: int | None,
    path_length: float,
    collision: bool = False,
) -> Row:
    return Row(
        policy=policy,
        condition="usual",
        repeat=0,
        seed=seed,
        map=name,
        success=steps is not None,
        steps=steps,
        collision=collision,
        path_length=path_length,
        shortest_path_length=2.0,
        distance=0.1,
    )
