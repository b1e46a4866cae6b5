"""The batch: each of its rows is a single environment."""

from functools import partial
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from _environments import assert_same
from _nav2d_env import ID, own_map, random_actions, velocity
from gymnasium.vector import AutoresetMode

import aicon_envs  # noqa: F401  (registers the environments)
from aicon_envs.nav2d import Nav2DVectorEnv, make_map


def test_make_vec_gives_the_native_batch() -> None:
    env = gym.make_vec(ID, num_envs=3, map="u_trap", autoreset_mode="Disabled")
    assert isinstance(env, Nav2DVectorEnv)
    assert env.max_episode_steps == 12_000
    assert env.metadata["autoreset_mode"] is AutoresetMode.DISABLED

    observation, _ = env.reset(seed=0)
    assert observation in env.observation_space


@pytest.mark.parametrize(
    "sensing", [pytest.param("range", marks=pytest.mark.slow), "range_bearing"]
)
def test_vector_equals_singles(sensing: Any) -> None:
    """Resets on the next step, truncations and collisions included; the infos too."""
    options = {"sensing": sensing, "map": "mixed", "max_episode_steps": 150}
    steps, num_envs = 400, 5
    singles = gym.vector.SyncVectorEnv([partial(gym.make, ID, **options)] * num_envs)
    batch = gym.make_vec(ID, num_envs=num_envs, **options)

    for first, second in zip(singles.reset(seed=4), batch.reset(seed=4), strict=True):
        assert_same(first, second)

    ended = 0
    drift = random_actions(1, num_envs, seed=1)[0]
    for action in random_actions(steps, num_envs):
        results = singles.step(action + drift), batch.step(action + drift)
        for first, second in zip(*results, strict=True):
            assert_same(first, second)
        ended += int(results[0][2].sum())
    assert ended > 0


def test_disabled_autoreset_freezes_finished_ones_until_they_are_reset() -> None:
    env = Nav2DVectorEnv(num_envs=2, autoreset_mode=AutoresetMode.DISABLED, max_episode_steps=100)
    near, far = own_map([], target=(0.5, 0.0)), own_map([], target=(9.0, 0.0))
    env.reset(seed=0, options={"per_env": [near, far]})
    forward = np.tile(velocity(0.5, 0.0), (2, 1))

    rewards, terminations, truncations, positions = [], [], [], []
    for _ in range(120):
        _, reward, terminated, truncated, info = env.step(forward)
        rewards.append(reward)
        terminations.append(terminated)
        truncations.append(truncated)
        positions.append(info["position"])

    # The near one arrives: from then on it rests, without reward.
    first = int(np.argmax(np.array(terminations)[:, 0]))
    assert 0 < first < 30
    assert np.array(terminations)[first:, 0].all() and not np.array(terminations)[:, 1].any()
    assert (np.array(rewards)[first + 1 :, 0] == 0.0).all()
    assert (np.array(positions)[first:, 0] == positions[first][0]).all()

    # The far one is truncated at the limit, and rests from then on.
    assert (np.array(truncations)[:, 1] == (np.arange(120) >= 99)).all()
    assert (np.array(positions)[99:, 1] == positions[99][1]).all()

    env.reset(options={"reset_mask": np.array([True, False]), "per_env": [near, far]})
    _, _, terminated, truncated, info = env.step(forward)
    assert terminated.tolist() == [False, False] and truncated.tolist() == [False, True]
    assert (info["position"][1] == positions[99][1]).all()


def test_a_start_at_the_target_is_an_arrival_in_the_first_step() -> None:
    """As of a single environment, whose wrapper resets it in the step after."""
    options = own_map([], target=(0.1, 0.0))
    singles = gym.vector.SyncVectorEnv([partial(gym.make, ID)] * 2)
    batch = Nav2DVectorEnv(2)
    for env in (singles, batch):
        env.reset(seed=0, options=options)

    for _ in range(3):
        expected, found = (env.step(np.full((2, 2), 0.1)) for env in (singles, batch))
        for first, second in zip(expected, found, strict=True):
            assert_same(first, second)


def test_an_option_that_is_none_is_not_given() -> None:
    env = Nav2DVectorEnv(2)
    env.reset(seed=0)
    usual = env.maps
    env.reset(seed=0, options={"map": [None, "mixed"], "map_seed": None, "start": None})
    assert env.maps == usual
    env.reset(seed=0, options={"per_env": [None, {}]})
    assert env.maps == usual


def test_options_and_seeds_per_environment() -> None:
    env = Nav2DVectorEnv(num_envs=2)
    options = {"map": ["maze", "u_trap"], "map_seed": [1, 2]}
    _, info = env.reset(seed=[3, None], options=options)

    assert info["map"].tolist() == ["maze", "u_trap_2"]
    assert info["map_seed"].tolist() == [1, 2]
    assert env.maps[0] == make_map("maze", np.random.default_rng(1))

    env.reset(options=own_map())
    assert [world.name for world in env.maps] == ["user", "user"]


def test_step_before_reset_is_an_error() -> None:
    with pytest.raises(gym.error.ResetNeeded):
        Nav2DVectorEnv(num_envs=1).step(np.zeros((1, 2), np.float32))


# --- errors name the argument


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        ({"num_envs": 0}, "num_envs"),
        ({"max_episode_steps": 0}, "max_episode_steps"),
        ({"autoreset_mode": AutoresetMode.SAME_STEP}, "NEXT_STEP"),
    ],
)
def test_bad_arguments(arguments: dict[str, Any], word: str) -> None:
    with pytest.raises(ValueError, match=word):
        Nav2DVectorEnv(**arguments)


@pytest.mark.parametrize(
    ("reset", "word"),
    [
        ({"seed": [1]}, "seed"),
        ({"options": {"map": ["maze"]}}, "map"),
        ({"options": {"per_env": [{}]}}, "per_env"),
        ({"options": {"per_env": [{}, {}], "map": "maze"}}, "per_env"),
        ({"options": {"reset_mask": np.zeros(2, dtype=bool)}}, "reset_mask"),
        ({"options": {"reset_mask": [1, 0]}}, "reset_mask"),
        ({"options": {"colour": 1}}, "colour"),
        ({"options": {"colour": None}}, "colour"),
        ({"options": {"per_env": [{}, 3]}}, "options must be a dictionary or None, got 3"),
        ({"options": {"map": np.array("nowhere")}}, "map must be one of"),
        ({"seed": np.array(3)}, "seed must be one integer or 2 of them"),
    ],
)
def test_bad_reset(reset: dict[str, Any], word: str) -> None:
    with pytest.raises(ValueError, match=word):
        Nav2DVectorEnv(num_envs=2).reset(**reset)
