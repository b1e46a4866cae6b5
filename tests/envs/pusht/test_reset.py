"""Seeds, and what the options of a reset ask for."""

import math
from typing import Any

import numpy as np
import pytest
from _environments import assert_same, assert_same_records
from _pusht_env import APART, DISTURBED, GOAL, rollout
from hypothesis import given
from hypothesis import strategies as st

from aicon_envs.pusht import OBJECTS, PushTEnv

# --- seeds


@pytest.mark.parametrize("arguments", [{}, DISTURBED])
def test_same_seed_and_actions_give_the_same_episode(arguments: Any) -> None:
    first = rollout(PushTEnv(**arguments), seed=5)
    second = rollout(PushTEnv(**arguments), seed=5)
    assert_same_records(first, second)


def test_a_used_environment_gives_the_same_episode_as_a_fresh_one() -> None:
    used = PushTEnv(**DISTURBED)
    rollout(used, seed=3)
    assert_same_records(rollout(used, seed=5), rollout(PushTEnv(**DISTURBED), seed=5))


def test_settings_leave_the_start_as_it_is() -> None:
    plain, _ = PushTEnv().reset(seed=4)
    disturbed, _ = PushTEnv(**DISTURBED).reset(seed=4)
    for key in plain:
        assert_same(plain[key], disturbed[key])


def test_noise_seed_changes_the_noise_and_nothing_else() -> None:
    env = PushTEnv(**DISTURBED)
    first = rollout(env, seed=4, options={"noise_seed": 1})
    again = rollout(env, seed=4, options={"noise_seed": 1})
    other = rollout(env, seed=4, options={"noise_seed": 2})

    def goals(record: list[Any]) -> list[Any]:
        return [info["goal_pose"] for info in record[5::4]]

    assert_same_records(first, again)
    assert_same(first[0], other[0])
    assert_same(goals(first), goals(other))
    assert (first[-1]["pos_agent"] != other[-1]["pos_agent"]).any()


# --- options


@given(
    x=st.floats(120.0, 390.0),
    y=st.floats(120.0, 390.0),
    angle=st.floats(-7.0, 7.0),
    object=st.sampled_from([*OBJECTS]),
)
def test_a_given_state_is_set_exactly(x: float, y: float, angle: float, object: str) -> None:
    env = PushTEnv(object=object, goal_pose=(x, y, math.remainder(angle, math.tau)))
    _, info = env.reset(options={"reset_to_state": [30.0, 500.0, x, y, angle]})

    np.testing.assert_allclose(info["pos_agent"], [30.0, 500.0], atol=0.0)
    np.testing.assert_allclose(info["block_pose"], [x, y, angle], atol=1e-9)
    assert info["coverage"] == pytest.approx(1.0)
    assert info["pose_error"] == pytest.approx(0.0, abs=1e-9)
    assert not info["is_success"]

    _, reward, terminated, _, info = env.step(np.array([30.0, 500.0], np.float32))
    assert terminated and info["is_success"] and reward == 1.0


def test_goal_of_one_reset() -> None:
    env = PushTEnv(observe_goal=True)
    options = {"goal_pose": (100.0, 200.0, -1.0)}
    observation, info = env.reset(seed=0, options=options)
    assert observation["goal_pose"].tolist() == [100.0, 200.0, -1.0]
    assert info["goal_pose"].tolist() == [100.0, 200.0, -1.0]

    _, random = env.reset(seed=0, options={"goal_pose": "random"})
    assert random["goal_pose"].tolist() != list(GOAL)

    _, usual = env.reset(seed=0)
    assert usual["goal_pose"].tolist() == list(GOAL)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"state": APART}, ["state", "reset_to_state", "goal_pose", "noise_seed"]),
        ({"reset_to_state": [0.0, 1.0]}, ["reset_to_state", "angle"]),
        ({"reset_to_state": [0.0, 1.0, 2.0, 3.0, math.nan]}, ["reset_to_state"]),
        ({"reset_to_state": [-1.0, 1.0, 2.0, 3.0, 0.0]}, ["reset_to_state", "512"]),
        ({"goal_pose": [0.0, 0.0, 10.0]}, ["goal_pose", "2π"]),
        ({"noise_seed": -1}, ["noise_seed"]),
    ],
)
def test_bad_options(options: dict[str, Any], words: list[str]) -> None:
    with pytest.raises(ValueError) as error:
        PushTEnv().reset(seed=0, options=options)
    assert all(word in str(error.value) for word in words), str(error.value)
