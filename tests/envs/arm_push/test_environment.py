"""The environment's contract: spaces, seeds, how episodes end, and errors."""

import math
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

pytest.importorskip("aicon_envs.arm_push")

from _arm_push_env import OBS_TYPES, RENDERS

from aicon_envs.arm_push import ArmPushEnv, resolve_object

PROPRIOCEPTION = {"q", "dq", "ft", "target"}


@pytest.fixture(scope="module")
def env() -> ArmPushEnv:
    return ArmPushEnv(obs_type="pose")


@pytest.mark.parametrize("obs_type", OBS_TYPES)
@pytest.mark.filterwarnings("ignore::UserWarning")  # they prefer actions within [-1, 1]
def test_the_checkers_of_gymnasium_and_stable_baselines3_are_content(obs_type: Any) -> None:
    sb3_checker = pytest.importorskip("stable_baselines3.common.env_checker")
    env = ArmPushEnv(obs_type=obs_type, render_mode="rgb_array" if RENDERS else None)

    check_env(env, skip_render_check=not RENDERS)
    sb3_checker.check_env(env, skip_render_check=not RENDERS)
    env.close()


def test_it_is_registered(env: ArmPushEnv) -> None:
    made = gym.make("aicon/ArmPush-v0", obs_type="pose")
    assert made.spec is not None and made.spec.max_episode_steps == 18_000
    assert made.observation_space == env.observation_space


@pytest.mark.parametrize("obs_type", OBS_TYPES)
def test_the_same_seed_gives_the_same_episode(obs_type: Any) -> None:
    def play() -> list[dict[str, Any]]:
        env = ArmPushEnv(obs_type=obs_type)
        observations = [env.reset(seed=5)[0]]
        observations += [env.step(np.full(7, 0.1))[0] for _ in range(7)]
        env.close()
        return observations

    for first, second in zip(play(), play(), strict=True):
        for key in first:
            np.testing.assert_array_equal(first[key], second[key])


def test_the_observation_has_what_sensors_give_and_the_truth_is_in_info(env: ArmPushEnv) -> None:
    observation, info = env.reset(seed=1)
    assert set(observation) == PROPRIOCEPTION | {"object_pose"}
    assert {"object_pose", "target_pose", "distance", "angle", "is_success"} <= set(info)
    assert info["limit_margin"] > 0 and info["self_distance"] > 0

    camera_space: Any = ArmPushEnv().observation_space
    assert set(camera_space) == PROPRIOCEPTION | {"rgb", "depth", "image_age"}


# --- how episodes end


def test_the_object_at_its_target_is_success(env: ArmPushEnv) -> None:
    pose = (0.5, 0.1, 1.0)
    tip = (0.6, -0.15)
    env.reset(seed=0, options={"object_pose": pose, "target_pose": pose, "tip": tip})
    _, reward, terminated, _, info = env.step(np.zeros(7))
    assert terminated and info["is_success"] and reward == pytest.approx(0.0, abs=1e-3)

    turned = (0.5, 0.1, 1.0 + math.radians(6))
    env.reset(seed=0, options={"object_pose": turned, "target_pose": pose, "tip": tip})
    _, _, terminated, _, info = env.step(np.zeros(7))
    assert not terminated and info["angle"] == pytest.approx(math.radians(6), abs=1e-3)


def test_an_object_that_falls_off_ends_the_episode(env: ArmPushEnv) -> None:
    env.reset(seed=0, options={"object_pose": (0.5, 0.62, 0.0), "tip": (0.55, -0.1)})

    for _ in range(100):
        *_, terminated, _, info = env.step(np.zeros(7))
        if terminated:
            break
    assert terminated and info["fallen"] and not info["is_success"]


def test_a_kick_moves_the_object() -> None:
    env = ArmPushEnv(obs_type="pose", kick_time=0.1)
    _, start = env.reset(seed=4)

    for _ in range(40):
        *_, info = env.step(np.zeros(7))
    assert np.linalg.norm(info["object_pose"][:2] - start["object_pose"][:2]) > 0.01


# --- errors name the argument


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"obs_type": "state"}, "obs_type must be one of"),
        ({"render_mode": "human"}, "rgb_array"),
        ({"mass": 0.0}, "mass must be a finite number > 0"),
        ({"friction": -1.0}, "friction must be a finite number > 0"),
        ({"object": "Q"}, "object must be one of"),
    ],
)
def test_wrong_arguments_are_named(arguments: dict[str, Any], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        ArmPushEnv(**arguments)


def test_an_unknown_object_lists_the_known_ones() -> None:
    with pytest.raises(ValueError, match="object must be one of T, L"):
        resolve_object("Q")


@pytest.mark.parametrize(
    "wrong",
    [
        None,
        3,
        [["a", "b"]],
        [[0, 0], [1]],
        [[0, 0], [1, 0], [0, 1]],
        [[0, 0], [0.01, 0], [0, 0.01]],
    ],
)
def test_an_outline_that_is_none_is_named(wrong: Any) -> None:
    with pytest.raises(ValueError, match=r"^object(, of which 600 px are 1 m: polygon)? must"):
        resolve_object(wrong)


def test_a_wrong_action_is_named(env: ArmPushEnv) -> None:
    env.reset(seed=0)
    with pytest.raises(ValueError, match="action must be finite"):
        env.step(np.full(7, np.nan))


def test_step_before_reset_is_an_error() -> None:
    with pytest.raises(gym.error.ResetNeeded):
        ArmPushEnv(obs_type="pose").step(np.zeros(7))
