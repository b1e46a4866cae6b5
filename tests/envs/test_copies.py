"""A copy of an environment in the middle of an episode goes on as the original does."""

import copy
import pickle
from collections.abc import Callable
from functools import partial
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

pytest.importorskip("pymunk")
pytest.importorskip("mujoco")
pytest.importorskip("trimesh")

from aicon_envs.arm_push import ArmPushEnv
from aicon_envs.nav2d import Nav2DEnv, Nav2DVectorEnv
from aicon_envs.pusht import PushTEnv
from aicon_envs.pusht.wrappers import Delay, Dropout, SensorNoise
from aicon_envs.reach import ReachEnv

DISTURBED: dict[str, Any] = {
    "action_noise": 4.0,
    "kick_interval": 7,
    "goal_jumps": 3,
    "observe_goal": True,
}


def wrapped() -> gym.Env[Any, Any]:
    """Pushing with every wrapper of ours."""
    return Delay(Dropout(SensorNoise(PushTEnv(), sigma=2.0), probability=0.3), steps=3)


ENVIRONMENTS: dict[str, Callable[[], Any]] = {
    "nav2d": Nav2DEnv,
    "nav2d_vector": partial(Nav2DVectorEnv, 3, max_episode_steps=20),
    "pusht": PushTEnv,
    "pusht_disturbed": partial(PushTEnv, **DISTURBED),
    "pusht_wrapped": wrapped,
    "arm_push": partial(ArmPushEnv, obs_type="pose"),
    "reach": partial(ReachEnv, "ur5", balls=1, ball_speed=0.2),
}
COPIES: dict[str, Callable[[Any], Any]] = {
    "deepcopy": copy.deepcopy,
    "pickle": lambda env: pickle.loads(pickle.dumps(env)),
}


def push(env: Any, steps: int, seed: int) -> list[Any]:
    """Act at random, toward the object where there is one, and return all that comes back."""
    generator = np.random.default_rng(seed)
    low, high = env.action_space.low, env.action_space.high

    results = []
    for _ in range(steps):
        action = generator.uniform(low, high)
        observation, reward, terminated, truncated, info = env.step(action)
        results.append([*observation.values(), reward, terminated, truncated, info])
    return results


@pytest.mark.parametrize("copied", COPIES.values(), ids=COPIES)
@pytest.mark.parametrize("make", ENVIRONMENTS.values(), ids=ENVIRONMENTS)
def test_a_copy_goes_on_number_for_number(
    make: Callable[[], Any], copied: Callable[[Any], Any]
) -> None:
    env = make()
    env.reset(seed=3)
    push(env, 30, seed=0)
    other = copied(env)
    of_copy = copied(other)

    expected = push(env, 30, seed=1)
    for again in (other, of_copy):
        np.testing.assert_equal(push(again, 30, seed=1), expected)


def test_a_copy_remembers_contacts() -> None:
    """The pusher leans on the object, which pymunk's own copies forget."""
    env = PushTEnv()
    _, info = env.reset(seed=0)
    while not info["n_contacts"]:
        *_, info = env.step(info["block_pose"][:2])
    other = copy.deepcopy(env)

    target = info["block_pose"][:2]
    for _ in range(20):
        *_, expected = env.step(target)
        *_, found = other.step(target)
        np.testing.assert_array_equal(found["block_pose"], expected["block_pose"])


def test_a_copy_is_on_its_own() -> None:
    env = PushTEnv()
    env.reset(seed=1)
    push(env, 5, seed=0)
    first, second = copy.deepcopy(env), copy.deepcopy(env)

    push(first, 20, seed=1)
    np.testing.assert_equal(push(second, 5, seed=2), push(env, 5, seed=2))


def test_an_environment_that_was_not_reset_is_copied_too() -> None:
    for make in ENVIRONMENTS.values():
        fresh = copy.deepcopy(make())
        fresh.reset(seed=0)
        push(fresh, 1, seed=0)


def test_a_copy_of_an_arm_that_has_seen_images_opens_its_own_cameras() -> None:
    env = ArmPushEnv(width=32, height=24)
    try:
        env.reset(seed=0)
    except RuntimeError as error:
        pytest.skip(f"no OpenGL without a display: {error}")
    expected = [push(other, 6, seed=0) for other in (copy.deepcopy(env), env)]
    np.testing.assert_equal(*expected)
