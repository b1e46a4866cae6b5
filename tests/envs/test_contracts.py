"""What Gymnasium's users expect of any environment: a reset that fails, views, spaces."""

import copy
from typing import Any

import numpy as np
import pytest
from gymnasium.error import ResetNeeded

pytest.importorskip("pymunk")
pytest.importorskip("mujoco")
pytest.importorskip("trimesh")

from aicon_envs.arm_push import ArmPushEnv
from aicon_envs.nav2d import Nav2DEnv, Nav2DVectorEnv
from aicon_envs.pusht import PushTEnv
from aicon_envs.pusht.wrappers import Delay
from aicon_envs.reach import ReachEnv

# --- a reset that fails


def test_after_a_first_reset_that_failed_there_is_nothing_to_step() -> None:
    env = ArmPushEnv(obs_type="pose")
    with pytest.raises(ValueError, match="no joint angles reach the tip"):
        env.reset(options={"tip": (3.0, 0.0)})
    with pytest.raises(ResetNeeded):
        env.step(np.zeros(7))


@pytest.mark.parametrize(
    ("env", "options"),
    [
        (Nav2DEnv(), {"map": "nowhere"}),
        (Nav2DVectorEnv(2), {"map": ["maze", "nowhere"]}),
        (PushTEnv(), {"goal_pose": (0.0, 0.0)}),
        (ArmPushEnv(obs_type="pose"), {"tip": (3.0, 0.0)}),
        (ReachEnv("ur5", balls=1), {"joints": [9.0] * 6}),
        (ReachEnv("ur5", balls=1), {"target_joints": [0.0] * 6}),  # no place for the ball
    ],
    ids=lambda value: type(value).__name__,
)
def test_a_reset_that_fails_leaves_the_episode_as_it_was(
    env: Any, options: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("aicon_envs.reach.reset._ATTEMPTS", 3)
    monkeypatch.setattr("aicon_envs.reach.reset.BASE_RADII", 3.0)
    action = 0.1 * np.ones(env.action_space.shape)
    env.reset(seed=0)
    env.step(action)
    untouched = copy.deepcopy(env)

    monkeypatch.setattr("aicon_envs.reach.reset.BASE_RADII", 1e3)
    with pytest.raises(ValueError, match=r"map|goal_pose|tip|joints|no place was found"):
        env.reset(options=options)

    # What is drawn next is other noise; the world is the same.
    *_, expected = untouched.step(action)
    *_, found = env.step(action)
    np.testing.assert_equal(found, expected)


# --- what is returned is the caller's


def test_arrays_that_a_step_returns_are_no_views_of_each_other() -> None:
    env = ArmPushEnv(obs_type="pose")
    _, info = env.reset(seed=0)
    assert not np.shares_memory(info["position"], info["tip"])


def test_a_delayed_observation_may_be_changed() -> None:
    env = Delay(PushTEnv(), steps=3)
    observation, _ = env.reset(seed=0)
    expected = observation["agent_pos"].copy()
    observation["agent_pos"][:] = -1.0
    again, *_ = env.step(np.zeros(2))
    np.testing.assert_array_equal(again["agent_pos"], expected)


def test_a_picture_may_be_drawn_into() -> None:
    env = Nav2DEnv(render_mode="rgb_array")
    env.reset(seed=0)
    picture = env.render()
    assert picture is not None and picture.flags.writeable


# --- spaces hold what is returned


def test_joints_without_ends_turn_on_and_on() -> None:
    env = ReachEnv("kinova", "position", speed=10.0)
    env.reset(seed=0)
    env.data.qpos[-1] = 15.0  # two turns and more
    env.data.act[-1] = 15.0
    observation, *_ = env.step(np.zeros(6))
    assert observation["q"].max() == pytest.approx(15.0, abs=0.1)
    assert env.observation_space.contains(observation)


def test_a_target_is_observed_as_it_was_given() -> None:
    env = ArmPushEnv(obs_type="pose")
    observation, _ = env.reset(seed=0, options={"target_pose": (0.5, 0.1, 20.0)})
    assert env.observation_space.contains(observation)
