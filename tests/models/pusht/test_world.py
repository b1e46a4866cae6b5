"""The pushing policy in the world: the cost falls, and nothing but the observation is used."""

import math
from typing import Any

import gym_pusht  # noqa: F401  (registers the environment)
import gymnasium as gym
import numpy as np
import pytest
import torch
from _asserts import assert_same_memory
from _inputs import driven
from _inputs.pushing import wandering
from numpy.typing import NDArray

import aicon_envs  # noqa: F401  (registers the environments)
from aicon_envs.pusht import OBJECTS
from aicon_torch import Policy
from aicon_torch.models.pusht import PIXEL

UPSTREAM = {"obs_type": "environment_state_agent_pos"}


def episode(
    env: gym.Env[Any, Any], policy: Policy, steps: int, seed: int
) -> tuple[list[float], list[NDArray[Any]]]:
    """The goal's cost after each step, and the actions."""
    observation, _ = env.reset(seed=seed)
    memory, costs, actions = None, [], []
    for _ in range(steps):
        action, memory = policy.predict(observation, memory)
        assert isinstance(action, np.ndarray) and action.dtype == np.float32
        assert env.action_space.contains(action)

        observation, _, terminated, _, _ = env.step(action)
        costs.append(float(policy.trace(memory).costs["push"]))
        actions.append(action)
        if terminated:
            break
    return costs, actions


@pytest.mark.parametrize("name", ["gym_pusht/PushT-v0", "aicon/PushT-v0"])
@pytest.mark.parametrize("seed", [1000, 1003])
def test_the_cost_falls(name: str, seed: int) -> None:
    """On the benchmark as it is, and on ours."""
    env = gym.make(name, **UPSTREAM)
    costs, _ = episode(env, driven("pusht"), 40, seed)
    assert costs[-1] < 0.5 * costs[0]


def test_equal_observations_are_equal_actions() -> None:
    """Both environments from one state, driven by one's actions: the policy says the same."""
    policy = driven("pusht")
    upstream, ours = (
        gym.make(name, **UPSTREAM) for name in ("gym_pusht/PushT-v0", "aicon/PushT-v0")
    )
    observation, other = upstream.reset(seed=1001)[0], ours.reset(seed=1001)[0]

    memory = others = None
    for _ in range(25):
        action, memory = policy.predict(observation, memory)
        same, others = policy.predict(other, others)
        np.testing.assert_allclose(same, action, atol=1e-3)
        observation, other = upstream.step(action)[0], ours.step(action)[0]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["L", "Z"])
def test_other_objects_are_pushed_too(name: str) -> None:
    there = OBJECTS[name]
    goal = (300.0, 220.0, -1.0)
    env = gym.make("aicon/PushT-v0", object=name, observe_goal=True, goal_pose=goal)
    policy = driven(
        "pusht",
        keypoints=tuple(map(tuple, (PIXEL * there.keypoints).tolist())),
        outline_order=tuple(there.border),
        observe_goal=True,
    )
    costs, _ = episode(env, policy, 40, 1000)
    assert costs[-1] < 0.6 * costs[0]


class Lying(gym.Wrapper[Any, Any, Any, Any]):
    """Tells the truth in the observation only: all else is wrong or in the way."""

    def reset(self, **options: Any) -> Any:
        observation, _ = super().reset(**options)
        wrong = {"block_pose": np.full(3, np.nan), "goal_pose": np.zeros(3), "coverage": 1.0}
        return observation, wrong

    def step(self, action: Any) -> Any:
        observation, _, _, truncated, _ = super().step(action)
        wrong = {"is_success": True, "vel_agent": np.full(2, 1e9)}
        return observation, math.nan, False, truncated, wrong

    def __getattr__(self, name: str) -> Any:
        raise AssertionError(f"the policy asked the environment for {name!r}")


@pytest.mark.parametrize("seed", [1002, 1004])
def test_nothing_but_the_observation_is_used(seed: int) -> None:
    honest, lying = gym.make("aicon/PushT-v0"), Lying(gym.make("aicon/PushT-v0"))
    actions, same = (episode(env, driven("pusht"), 15, seed)[1] for env in (honest, lying))
    np.testing.assert_array_equal(actions, same)


def test_what_else_is_in_an_observation_is_ignored() -> None:
    policy, (reading,) = driven("pusht"), wandering(1, 2)
    more = reading | {
        "block_pose": torch.full((2, 3), torch.nan),
        "goal_pose": torch.zeros(2, 3),
        "n_contacts": "many",
    }
    _, expected = policy.predict(reading)
    _, memory = policy.predict(more)
    assert_same_memory(memory, expected, 0.0)
