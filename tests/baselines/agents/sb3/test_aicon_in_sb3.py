"""Our pushT policy in stable-baselines3's loop."""

from typing import Any

import gymnasium as gym
import pytest

pytest.importorskip("stable_baselines3")
pytest.importorskip("pymunk")

from _inputs import driven
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.vec_env import DummyVecEnv

import aicon_envs  # noqa: F401  (registers the environments)


def make_env() -> gym.Env[Any, Any]:
    return gym.make("aicon/PushT-v0", max_episode_steps=1000)


@pytest.mark.parametrize("count", [1, 2], ids=["plain", "DummyVecEnv"])
def test_evaluate_policy_runs_pusht(count: int) -> None:
    env: Any = make_env() if count == 1 else DummyVecEnv([make_env] * count)
    env.reset(seed=1000) if count == 1 else env.seed(1000)
    successes: list[bool] = []

    def record(local: dict[str, Any], _: dict[str, Any]) -> None:
        if local["done"]:
            successes.append(local["info"]["is_success"])

    rewards, lengths = evaluate_policy(
        driven("pusht"),
        env,
        2,
        callback=record,
        return_episode_rewards=True,
        warn=False,
    )

    assert successes == [True, True]
    for reward, length in zip(rewards, lengths, strict=True):
        assert length < 1000
        assert 0.0 < reward <= length
