import ctypes.util
import math
import os
import subprocess
import sys

import gymnasium as gym
import numpy as np
import pytest
import stable_baselines3.common.env_checker as sb3_checker
from gymnasium.utils.env_checker import check_env

pytest.importorskip("aicon_envs.panda_push")

from aicon_envs.panda_push import PandaPushEnv, resolve_object  # needs MuJoCo


def can_render():
    try:
        env = PandaPushEnv()
        env.reset(seed=0)
        env.close()
    except RuntimeError:
        return False
    return True


RENDERS = can_render()
needs_rendering = pytest.mark.skipif(not RENDERS, reason="no OpenGL without a display")
OBS_TYPES = ["pose", pytest.param("rgbd", marks=needs_rendering)]


@pytest.fixture(scope="module")
def env():
    return PandaPushEnv(obs_type="pose")


@pytest.mark.parametrize("obs_type", OBS_TYPES)
@pytest.mark.filterwarnings("ignore::UserWarning")  # the checkers prefer actions within [-1, 1] and images as uint8
def test_the_checkers_of_gymnasium_and_stable_baselines3_are_content(obs_type):
    env = PandaPushEnv(obs_type=obs_type, render_mode="rgb_array" if RENDERS else None)
    check_env(env, skip_render_check=not RENDERS)
    sb3_checker.check_env(env, skip_render_check=not RENDERS)
    env.close()


@pytest.mark.parametrize("obs_type", OBS_TYPES)
def test_the_same_seed_gives_the_same_episode(obs_type):
    def play():
        env = PandaPushEnv(obs_type=obs_type)
        observations = [env.reset(seed=5)[0]]
        observations += [env.step(np.full(7, 0.1))[0] for _ in range(7)]
        env.close()
        return observations

    for one, other in zip(play(), play(), strict=True):
        for key in one:
            np.testing.assert_array_equal(one[key], other[key])


def test_it_is_registered(env):
    made = gym.make("aicon/PandaPush-v0", obs_type="pose")
    assert made.spec.max_episode_steps == 18_000
    assert made.observation_space == env.observation_space


def test_the_observation_has_what_sensors_give_and_the_truth_is_in_info():
    observation, info = PandaPushEnv(obs_type="pose").reset(seed=1)
    assert set(observation) == {"q", "dq", "ft", "target", "object_pose"}
    assert set(PandaPushEnv().observation_space) == {"q", "dq", "ft", "target", "rgb", "depth", "image_age"}
    assert {"object_pose", "target_pose", "distance", "angle", "is_success", "collision"} <= set(info)
    assert info["limit_margin"] > 0 and info["self_distance"] > 0


@pytest.mark.parametrize("seed", range(8))
def test_episodes_start_upright_beside_the_object_and_within_limits(env, seed):
    _, info = env.reset(seed=seed)
    assert not info["is_success"] and not info["collision"] and not info["fallen"]
    assert info["limit_margin"] > 0.1
    assert info["tip"][2] == pytest.approx(0.02, abs=1e-3)
    assert 0.48 <= info["object_pose"][0] <= 0.60 and abs(info["object_pose"][1]) <= 0.15


def test_joint_velocities_are_those_commanded(env):
    env.reset(seed=2)
    velocity = np.array([0.1, -0.1, 0.05, 0.1, -0.05, 0.1, 0.2])
    before, *_ = [env.step(velocity) for _ in range(50)][-1]  # the servos lag behind by 0.1 s
    observation, *_ = [env.step(velocity) for _ in range(50)][-1]
    np.testing.assert_allclose(observation["q"] - before["q"], 0.5 * velocity, atol=0.002)
    np.testing.assert_allclose(observation["dq"], velocity, atol=0.01)


def test_the_wrist_feels_the_weight_of_the_tool(env):
    readings = [env.reset(seed=3)[0]["ft"]] + [env.step(np.zeros(7))[0]["ft"] for _ in range(50)]
    assert np.mean(readings, axis=0)[2] == pytest.approx(-0.25 * 9.81, abs=0.1)


def test_the_object_at_its_target_is_success(env):
    pose = (0.5, 0.1, 1.0)
    env.reset(seed=0, options={"object_pose": pose, "target_pose": pose, "tip": (0.6, -0.15)})
    _, reward, terminated, _, info = env.step(np.zeros(7))
    assert terminated and info["is_success"] and reward == pytest.approx(0.0, abs=1e-3)
    turned = (0.5, 0.1, 1.0 + math.radians(6))
    env.reset(seed=0, options={"object_pose": turned, "target_pose": pose, "tip": (0.6, -0.15)})
    _, _, terminated, _, info = env.step(np.zeros(7))
    assert not terminated and info["angle"] == pytest.approx(math.radians(6), abs=1e-3)


def test_an_object_that_falls_off_ends_the_episode(env):
    env.reset(seed=0, options={"object_pose": (0.5, 0.62, 0.0), "tip": (0.55, -0.1)})
    for _ in range(100):
        *_, terminated, _, info = env.step(np.zeros(7))
        if terminated:
            break
    assert terminated and info["fallen"] and not info["is_success"]


def test_a_kick_moves_the_object():
    env = PandaPushEnv(obs_type="pose", kick_time=0.1)
    _, start = env.reset(seed=4)
    for _ in range(40):
        *_, info = env.step(np.zeros(7))
    assert np.linalg.norm(info["object_pose"][:2] - start["object_pose"][:2]) > 0.01


@needs_rendering
def test_images_come_at_20_hertz_and_late_ones_are_late():
    for delay in (0.0, 0.1):
        env = PandaPushEnv(image_delay=delay)
        ages = [env.reset(seed=1)[0]["image_age"][0]]
        ages += [env.step(np.zeros(7))[0]["image_age"][0] for _ in range(40)]
        np.testing.assert_allclose(ages[20:26], delay + np.array([0.0, 0.01, 0.02, 0.03, 0.04, 0.0]), atol=1e-9)
        env.close()


@needs_rendering
def test_the_camera_shows_a_red_object_on_a_bright_table():
    env = PandaPushEnv(render_mode="rgb_array")
    observation, _ = env.reset(seed=1)
    red, green, blue = observation["rgb"].astype(int).transpose(2, 0, 1)
    assert (red > 1.5 * np.maximum(green, blue)).mean() > 0.05
    assert 0.2 < np.median(observation["depth"]) < 0.4
    assert env.render().shape == (480, 640, 3)
    env.close()


@pytest.mark.parametrize("backend", ["disable", "none is there", "osmesa"])
def test_where_nothing_can_render_an_error_names_the_packages(backend):
    if backend == "osmesa" and ctypes.util.find_library("OSMesa"):
        pytest.skip("OSMesa is there")
    environment = {key: value for key, value in os.environ.items() if key not in ("MUJOCO_GL", "DISPLAY")}
    hide = "import ctypes.util; ctypes.util.find_library = lambda name: None; " if "none" in backend else ""
    code = f"{hide}import aicon_envs.panda_push as panda; panda.PandaPushEnv().reset(seed=0)"
    if not hide:
        environment["MUJOCO_GL"] = backend
    result = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=False)
    assert result.returncode == 1
    message = result.stderr.strip().splitlines()[-1]
    assert message.startswith("RuntimeError: MuJoCo can") and "libegl1 libegl-mesa0 libgl1-mesa-dri" in message


def test_wrong_arguments_are_named(env):
    with pytest.raises(ValueError, match="obs_type must be one of"):
        PandaPushEnv(obs_type="state")
    with pytest.raises(ValueError, match="object must be one of"):
        resolve_object("Q")
    with pytest.raises(ValueError, match="mass must be positive"):
        PandaPushEnv(mass=0.0)
    with pytest.raises(ValueError, match="unknown option"):
        env.reset(options={"goal": 1})
    env.reset(seed=0)
    with pytest.raises(ValueError, match="seven finite numbers"):
        env.step(np.full(7, np.nan))
