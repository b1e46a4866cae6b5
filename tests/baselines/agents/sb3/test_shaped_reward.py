from typing import Any

import numpy as np
import pytest

pytest.importorskip("stable_baselines3")
pytest.importorskip("pymunk")

import gymnasium as gym
from _inputs import driven

import aicon_envs  # noqa: F401  (registers the environments)
from aicon_baselines.agents.sb3.wrappers import ShapedReward


def potential(observation: dict[str, Any], info: dict[str, Any], approach: float) -> float:
    keypoints = observation["environment_state"].reshape(-1, 2)
    distances = [np.hypot(*(keypoint - observation["agent_pos"])) for keypoint in keypoints]
    return -info["pose_error"] - approach * min(distances)


def test_a_shaped_episode_is_worth_the_difference_of_its_ends() -> None:
    env = ShapedReward(gym.make("aicon/PushT-v0"), approach=0.5)
    policy, memory, total, done = driven("pusht"), None, 0.0, False
    observation, info = env.reset(seed=1000)
    start = potential(observation, info, 0.5)

    while not done:
        action, memory = policy.predict(observation, memory)
        observation, reward, terminated, truncated, info = env.step(action)
        total += reward
        done = terminated or truncated

    assert info["is_success"]
    end = potential(observation, info, 0.5)
    assert total == pytest.approx((end - start) / 100.0 + 5.0)
