"""A wrong call of any environment is an error that says what would be right."""

from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.error import ResetNeeded

pytest.importorskip("pymunk")
pytest.importorskip("mujoco")
pytest.importorskip("trimesh")

from aicon_envs.arm_push import ArmPushEnv
from aicon_envs.nav2d import Nav2DEnv, Nav2DVectorEnv
from aicon_envs.pusht import PushTEnv
from aicon_envs.reach import ReachEnv

SINGLE: dict[str, Any] = {
    "nav2d": Nav2DEnv(),
    "pusht": PushTEnv(),
    "arm_push": ArmPushEnv(obs_type="pose"),
    "reach": ReachEnv("ur5"),
}
VECTOR: dict[str, Any] = {"nav2d": Nav2DVectorEnv(2)}
ALL = [*SINGLE.values(), *VECTOR.values()]


KINDS = [Nav2DEnv, PushTEnv, ArmPushEnv, ReachEnv, Nav2DVectorEnv]


@pytest.mark.parametrize("kind", KINDS)
def test_before_the_first_reset_there_is_nothing_to_step_or_draw(kind: Any) -> None:
    env = kind(render_mode="rgb_array")
    with pytest.raises(ResetNeeded, match="reset"):
        env.step(np.zeros(env.action_space.shape))
    with pytest.raises(ResetNeeded, match="reset"):
        env.render()


def test_before_the_first_reset_there_is_no_map() -> None:
    with pytest.raises(ResetNeeded):
        _ = Nav2DEnv().map
    with pytest.raises(ResetNeeded):
        _ = Nav2DVectorEnv(2).maps


@pytest.mark.parametrize("env", ALL, ids=lambda env: type(env).__name__)
@pytest.mark.parametrize("wrong", [np.zeros(3), np.zeros((3, 3)), 0.0, "left", None, [[1], [1, 2]]])
def test_an_action_of_another_shape_or_kind_is_refused(env: Any, wrong: Any) -> None:
    env.reset(seed=0)
    with pytest.raises(ValueError, match="action must be"):
        env.step(wrong)


@pytest.mark.parametrize("env", ALL, ids=lambda env: type(env).__name__)
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_an_action_that_is_not_finite_is_refused_and_changes_nothing(
    env: Any, value: float
) -> None:
    _, before = env.reset(seed=0)
    action = np.zeros(env.action_space.shape)
    action.flat[-1] = value
    with pytest.raises(ValueError, match="action must be finite, got"):
        env.step(action)

    _, after = env.reset(seed=0)
    np.testing.assert_array_equal(
        after["position" if "position" in after else "pos_agent"],
        before["position" if "position" in before else "pos_agent"],
    )


@pytest.mark.parametrize("env", ALL, ids=lambda env: type(env).__name__)
def test_options_that_are_none_or_unknown_are_refused(env: Any) -> None:
    with pytest.raises(ValueError, match="options must be a dictionary or None, got 'maze'"):
        env.reset(options="maze")
    with pytest.raises(ValueError, match="unknown option speed; valid options are"):
        env.reset(options={"speed": 3})


@pytest.mark.parametrize("env", VECTOR.values(), ids=VECTOR)
def test_seeds_of_a_vector_are_one_integer_or_a_list_of_them(env: Any) -> None:
    first, _ = env.reset(seed=np.int64(3))
    second, _ = env.reset(seed=[3, np.int64(4)])
    for name in first:
        np.testing.assert_array_equal(first[name], second[name])

    for wrong in ("ab", 1.5, [1], [1, 2, 3]):
        with pytest.raises(ValueError, match="seed must be one integer or 2 of them, got"):
            env.reset(seed=wrong)
    with pytest.raises(ValueError, match="seed must be an integer >= 0, got 1.5"):
        env.reset(seed=[1, 1.5])


@pytest.mark.parametrize("kind", [Nav2DVectorEnv])
@pytest.mark.parametrize("name", ["num_envs", "max_episode_steps"])
@pytest.mark.parametrize("count", [0, -1, 1.5, "two"])
def test_counts_are_integers_of_one_or_more(kind: Any, name: str, count: Any) -> None:
    with pytest.raises(ValueError, match=f"{name} must be an integer >= 1, got"):
        kind(**{name: count})


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"object_pose": (0.5, np.nan, 0.0)}, "object_pose must be .x, y, angle., finite"),
        ({"target_pose": (0.5, 0.0)}, "target_pose must be"),
        ({"tip": "here"}, "tip must be .x, y., finite"),
        ({"yaw": np.inf}, "yaw must be a finite angle"),
    ],
)
def test_options_of_the_arm_are_finite(options: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        SINGLE["arm_push"].reset(options=options)


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        ({"depth_noise": -1.0}, "depth_noise"),
        ({"image_delay": np.nan}, "image_delay"),
        ({"kick_time": "soon"}, "kick_time"),
        ({"width": 0}, "width"),
        ({"render_height": 1.5}, "render_height"),
        ({"area": ((0.5, 0.4), (0.0, 0.1))}, "area"),
        ({"area": 3}, "area"),
    ],
)
def test_arguments_of_the_arm_are_named(arguments: dict[str, Any], name: str) -> None:
    with pytest.raises(ValueError, match=f"{name} must be"):
        ArmPushEnv(**arguments)


def test_gymnasium_makes_the_same_errors() -> None:
    env = gym.make("aicon/Nav2D-v0")
    with pytest.raises(ResetNeeded):
        env.step(np.zeros(2))
