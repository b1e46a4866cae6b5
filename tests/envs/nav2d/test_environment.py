"""The environment's contract: spaces, seeds, and errors that name the argument."""

import math
import warnings
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from _nav2d_env import ID, SENSING, random_actions, rollout
from gymnasium.utils.env_checker import check_env
from hypothesis import given, settings
from hypothesis import strategies as st

import aicon_envs  # noqa: F401  (registers the environments)
from aicon_envs.nav2d import Nav2DEnv, Nav2DVectorEnv

# --- the contracts of Gymnasium and stable-baselines3


@pytest.mark.parametrize("sensing", SENSING)
@pytest.mark.parametrize("render_mode", [None, "rgb_array"])
def test_gymnasium_accepts_it_without_a_warning(sensing: Any, render_mode: str | None) -> None:
    env = gym.make(ID, sensing=sensing, render_mode=render_mode)

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env.unwrapped)


@pytest.mark.parametrize("sensing", SENSING)
@pytest.mark.parametrize("wrapped", [False, True])
def test_stable_baselines3_accepts_it_without_a_warning(sensing: Any, wrapped: bool) -> None:
    checker = pytest.importorskip("stable_baselines3.common.env_checker")
    env = gym.make(ID, sensing=sensing, render_mode="rgb_array")

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        checker.check_env(env if wrapped else env.unwrapped, skip_render_check=False)


def test_registered_limit_and_spaces() -> None:
    expected = {
        "range": {"bearing", "range"},
        "range_bearing": {"bearing", "range", "obstacle_bearing"},
    }

    assert gym.spec(ID).max_episode_steps == 12_000
    for sensing, keys in expected.items():
        space = gym.make(ID, sensing=sensing).observation_space
        assert isinstance(space, gym.spaces.Dict)
        assert set(space) == keys
        assert all(box.shape == (1,) and box.dtype == np.float32 for box in space.values())


@settings(max_examples=25, deadline=None)
@given(
    bearing_noise=st.floats(0.0, 10.0),
    range_noise=st.floats(0.0, 10.0),
    max_range=st.floats(0.01, 100.0),
    seed=st.integers(0, 2**32),
)
def test_observations_stay_in_their_space(
    bearing_noise: float, range_noise: float, max_range: float, seed: int
) -> None:
    env = Nav2DEnv(
        map="long_wall",
        sensing="range_bearing",
        bearing_noise=bearing_noise,
        range_noise=range_noise,
        max_range=max_range,
    )
    observation, _ = env.reset(seed=seed)

    for action in random_actions(10):
        assert observation in env.observation_space
        observation, _, _, _, _ = env.step(action)


# --- seeds


@pytest.mark.parametrize("sensing", SENSING)
def test_same_seed_and_actions_give_the_same_trajectory(sensing: Any) -> None:
    actions = random_actions(300)
    first = rollout(Nav2DEnv(sensing=sensing), actions, seed=5)
    second = rollout(Nav2DEnv(sensing=sensing), actions, seed=5)
    np.testing.assert_array_equal(first, second)


def test_another_seed_gives_another_trajectory() -> None:
    actions = random_actions(5)
    first = rollout(Nav2DEnv(map="clutter"), actions, seed=0)
    second = rollout(Nav2DEnv(map="clutter"), actions, seed=1)
    assert (first != second).any()


def test_unseeded_reset_continues_the_stream() -> None:
    actions = random_actions(20)

    sequences = []
    for _ in range(2):
        env = Nav2DEnv()
        seeded = rollout(env, actions, seed=3)
        sequences.append([seeded, rollout(env, actions), rollout(env, actions)])

    for first, second in zip(*sequences, strict=True):
        np.testing.assert_array_equal(first, second)
    assert len({episode.tobytes() for episode in sequences[0]}) == 3


# --- errors name the argument


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        ({"map": "nowhere"}, "u_trap_05"),
        ({"sensing": "lidar"}, "range_bearing"),
        ({"render_mode": "human"}, "rgb_array"),
        ({"range_noise": -0.1}, "range_noise"),
        ({"max_speed": 0.0}, "max_speed"),
        ({"dt": math.nan}, "dt"),
        ({"max_speed": 10.0}, "max_speed"),
    ],
)
@pytest.mark.parametrize("kind", [Nav2DEnv, Nav2DVectorEnv])
def test_bad_arguments(kind: Any, arguments: dict[str, Any], word: str) -> None:
    with pytest.raises(ValueError, match=word):
        kind(**arguments)


@pytest.mark.parametrize("kind", [Nav2DEnv, Nav2DVectorEnv])
def test_unknown_argument_lists_the_valid_ones(kind: Any) -> None:
    with pytest.raises(
        TypeError, match="rnge_noise; .* are .*map, sensing, render_mode, .*range_noise"
    ):
        kind(rnge_noise=0.1)


@pytest.mark.parametrize("action", [[math.nan, 0.0], [math.inf, 0.0], [0.0], [[0.0, 0.0]], 0.0])
def test_bad_action(action: Any) -> None:
    env = Nav2DEnv(map="long_wall")
    env.reset(seed=0)

    with pytest.raises(ValueError, match="action"):
        env.step(np.array(action, dtype=np.float32))
