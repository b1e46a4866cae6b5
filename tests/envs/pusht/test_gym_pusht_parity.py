"""With the same seeds and actions, our episodes and pictures are those of gym-pusht."""

from typing import Any

import gymnasium as gym
import numpy as np
import pymunk
import pytest
from _environments import assert_same
from _pusht_env import OBS_TYPES, push, pushes, random_actions
from numpy.typing import NDArray

from aicon_envs.pusht import PushTEnv


@pytest.fixture
def upstream() -> Any:
    pytest.importorskip("gym_pusht")

    def make(**arguments: Any) -> Any:
        return gym.make("gym_pusht/PushT-v0", **arguments).unwrapped

    return make


def wander(info: dict[str, Any], noise: NDArray[np.float64]) -> NDArray[np.float64]:
    """A target around the middle, wherever the object is."""
    return (256.0 + 100.0 * noise).clip(0.0, 512.0)


@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(1, 6))]
)
def test_episodes_are_those_of_gym_pusht(upstream: Any, seed: int) -> None:
    theirs, ours = upstream(obs_type="environment_state_agent_pos"), PushTEnv()

    contacts = 0
    for choose_target in (push, wander):
        expected, their_info = theirs.reset(seed=seed)
        observation, info = ours.reset(seed=seed)

        for noise in pushes(300, seed):
            assert_same(expected, observation, 1e-9)
            assert_same(their_info, {key: info[key] for key in their_info}, 1e-9)

            action = choose_target(their_info, noise).astype(np.float32)
            expected, *their_results, their_info = theirs.step(action)
            observation, *results, info = ours.step(action)
            np.testing.assert_allclose(their_results, results, rtol=0.0, atol=1e-9)
            contacts += info["n_contacts"]

    assert contacts > 10


def test_later_starts_without_a_seed_are_those_of_gym_pusht(upstream: Any) -> None:
    theirs = upstream(obs_type="state")
    ours = PushTEnv(obs_type="state", action_noise=3.0, kick_interval=2)

    for seed in (7, None, None, None):
        assert_same(theirs.reset(seed=seed)[0], ours.reset(seed=seed)[0], 1e-9)
        for action in random_actions(5):
            ours.step(action)


@pytest.mark.parametrize(
    "obs_type", [pytest.param("pixels", marks=pytest.mark.slow), "pixels_agent_pos"]
)
def test_pictures_are_those_of_gym_pusht(upstream: Any, obs_type: Any) -> None:
    """Number for number."""
    theirs, ours = upstream(obs_type=obs_type), PushTEnv(obs_type=obs_type)

    for seed in range(4):
        expected, info = theirs.reset(seed=seed)
        observation, _ = ours.reset(seed=seed)

        for noise in pushes(40, seed):
            assert_same(expected, observation)
            action = push(info, noise)
            expected, _, _, _, info = theirs.step(action)
            observation, _, _, _, _ = ours.step(action)


def test_rendering_is_that_of_gym_pusht_but_for_rounding(upstream: Any) -> None:
    theirs, ours = upstream(render_mode="rgb_array"), PushTEnv(render_mode="rgb_array")
    theirs.reset(seed=1)
    ours.reset(seed=1)

    expected, picture = theirs.render().astype(int), np.asarray(ours.render()).astype(int)
    assert np.abs(expected - picture).max() <= 1


@pytest.mark.parametrize("obs_type", OBS_TYPES)
def test_spaces_are_those_of_gym_pusht(upstream: Any, obs_type: Any) -> None:
    theirs, ours = upstream(obs_type=obs_type), PushTEnv(obs_type=obs_type)
    assert theirs.observation_space == ours.observation_space
    assert theirs.action_space == ours.action_space


def test_pymunk_is_of_the_major_version_whose_physics_are_compared() -> None:
    assert pymunk.version.split(".")[0] == "6"
