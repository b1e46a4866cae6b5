"""Pictures of the navigation world."""

import gymnasium as gym
import numpy as np
from _nav2d_env import ID, velocity

import aicon_envs  # noqa: F401  (registers the environments)
from aicon_envs.nav2d import Nav2DVectorEnv


def test_pictures_show_the_agent_moving() -> None:
    env = gym.make(ID, map="bug_trap", render_mode="rgb_array")
    env.reset(seed=0)

    first = env.render()
    for _ in range(20):
        env.step(velocity(0.5, 0.0))
    second = env.render()

    for picture in (first, second):
        assert isinstance(picture, np.ndarray)
        assert picture.shape == (480, 480, 3) and picture.dtype == np.uint8
    assert not np.array_equal(np.asarray(first), np.asarray(second))


def test_vector_pictures() -> None:
    env = Nav2DVectorEnv(num_envs=2, render_mode="rgb_array")
    env.reset(seed=0)
    env.step(np.zeros((2, 2), np.float32))

    assert [picture.shape for picture in env.render() or ()] == [(480, 480, 3)] * 2
    assert Nav2DVectorEnv(num_envs=1).render() is None
