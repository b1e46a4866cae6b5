"""The batch: each of its rows is a single environment."""

from functools import partial
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from _environments import assert_same
from _pusht_env import APART, DISTURBED, GOAL, ID, random_actions
from gymnasium.vector import AutoresetMode

import aicon_envs  # noqa: F401  (registers the environments)
from aicon_envs.pusht import PushTEnv, PushTVectorEnv

SOLVED = {"reset_to_state": [*APART[:2], *GOAL]}


def test_make_vec_gives_the_native_batch() -> None:
    env = gym.make_vec(ID, num_envs=3, object="L", autoreset_mode="Disabled")
    assert isinstance(env, PushTVectorEnv)
    assert env.max_episode_steps == 300
    assert env.metadata["autoreset_mode"] is AutoresetMode.DISABLED

    observation, _ = env.reset(seed=0)
    assert observation in env.observation_space


@pytest.mark.parametrize(
    "arguments", [{}, {"obs_type": "state"}, {"obs_type": "pixels"}, DISTURBED]
)
def test_vector_equals_singles(arguments: Any) -> None:
    """Resets on the next step, truncations and successes included; the infos too."""
    steps, num_envs, limit = 40, 3, 17
    make = partial(gym.make, ID, max_episode_steps=limit, **arguments)
    singles = gym.vector.SyncVectorEnv([make] * num_envs)
    batch = gym.make_vec(ID, num_envs=num_envs, max_episode_steps=limit, **arguments)
    results: list[Any] = [env.reset(seed=4, options=SOLVED) for env in (singles, batch)]

    ended = 0
    for action in random_actions(steps, num_envs):
        *firsts, first_info = results[0]
        *seconds, second_info = results[1]
        for first, second in zip(firsts, seconds, strict=True):
            assert_same(first, second)
        assert_same(first_info, {key: second_info[key] for key in first_info})

        results = [singles.step(action), batch.step(action)]
        _, _, terminated, truncated, _ = results[0]
        ended += terminated.sum() + truncated.sum()

    assert ended >= (2 if "goal_jumps" in arguments else 3) * num_envs


def test_disabled_autoreset_freezes_finished_ones_until_they_are_reset() -> None:
    env = PushTVectorEnv(num_envs=2, autoreset_mode=AutoresetMode.DISABLED, max_episode_steps=10)
    apart = {"reset_to_state": APART}
    env.reset(options={"per_env": [SOLVED, apart]})
    action = np.full((2, 2), 100.0)

    positions, rewards = [], []
    for step in range(1, 14):
        _, reward, terminated, truncated, info = env.step(action)
        assert terminated.tolist() == [True, False] and truncated.tolist() == [False, step >= 10]
        assert info["is_success"].tolist() == [True, False] and not info["collision"].any()
        positions.append(info["position"])
        rewards.append(reward[0])

    # The first rests from its success on, the second from its truncation on.
    assert rewards == [1.0] + [0.0] * 12
    assert (np.array(positions)[:, 0] == positions[0][0]).all()
    assert (np.array(positions)[9:, 1] == positions[9][1]).all()
    assert (positions[8][1] != positions[9][1]).any()

    options = {"reset_mask": np.array([False, True]), "per_env": [{}, apart]}
    _, info = env.reset(options=options)
    assert info["_position"].tolist() == [False, True]
    assert (info["position"][0] == positions[0][0]).all()

    _, _, terminated, truncated, _ = env.step(action)
    assert terminated.tolist() == [True, False] and truncated.tolist() == [False, False]


def test_infos_have_the_names_of_the_evaluation() -> None:
    env = PushTVectorEnv(num_envs=3, object="U")
    _, info = env.reset(seed=[3, None, 5])

    shapes = {"is_success": (3,), "coverage": (3,), "distance": (3,), "collision": (3,)}
    shapes |= {"position": (3, 2), "block_pose": (3, 3), "goal_pose": (3, 3)}
    assert {key: info[key].shape for key in shapes} == shapes

    _, expected = PushTEnv(object="U").reset(seed=5)
    assert info["distance"][2] == expected["pose_error"]
    assert info["position"][2].tolist() == expected["pos_agent"].tolist()


def test_step_before_reset_is_an_error() -> None:
    with pytest.raises(gym.error.ResetNeeded):
        PushTVectorEnv(num_envs=1).step(np.zeros((1, 2), np.float32))


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
        PushTVectorEnv(**arguments)


@pytest.mark.parametrize(
    ("reset", "word"),
    [
        ({"seed": [1]}, "seed"),
        ({"options": {"per_env": [{}]}}, "per_env"),
        ({"options": {"per_env": [{}, {}], "goal_pose": "random"}}, "per_env"),
        ({"options": {"reset_mask": np.zeros(2, dtype=bool)}}, "reset_mask"),
        ({"options": {"reset_mask": [1, 0]}}, "reset_mask"),
        ({"options": {"colour": 1}}, "colour"),
    ],
)
def test_bad_reset(reset: dict[str, Any], word: str) -> None:
    with pytest.raises(ValueError, match=word):
        PushTVectorEnv(num_envs=2).reset(**reset)
