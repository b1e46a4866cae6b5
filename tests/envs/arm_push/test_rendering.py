"""Images and pictures, and what happens where nothing can render."""

import ctypes.util
import os
import subprocess
import sys
from typing import Any

import numpy as np
import pytest

pytest.importorskip("aicon_envs.arm_push")

from _arm_push_env import needs_rendering

from aicon_envs.arm_push import ArmPushEnv

PACKAGES = "libegl1 libegl-mesa0 libgl1-mesa-dri"


@needs_rendering
@pytest.mark.parametrize("delay", [0.0, 0.1])
def test_images_come_at_20_hertz_and_late_ones_are_late(delay: float) -> None:
    env = ArmPushEnv(image_delay=delay)
    ages = [env.reset(seed=1)[0]["image_age"][0]]
    ages += [env.step(np.zeros(7))[0]["image_age"][0] for _ in range(40)]
    env.close()

    expected = delay + np.array([0.0, 0.01, 0.02, 0.03, 0.04, 0.0])
    np.testing.assert_allclose(ages[20:26], expected, atol=1e-9)


@needs_rendering
def test_the_camera_shows_a_red_object_on_a_bright_table() -> None:
    env = ArmPushEnv(render_mode="rgb_array")
    observation, _ = env.reset(seed=1)

    red, green, blue = observation["rgb"].astype(int).transpose(2, 0, 1)
    assert (red > 1.5 * np.maximum(green, blue)).mean() > 0.05
    assert 0.2 < np.median(observation["depth"]) < 0.4

    picture = env.render()
    assert picture is not None and picture.shape == (480, 640, 3)
    env.close()


@pytest.mark.parametrize(
    "backend", [pytest.param("disable", marks=pytest.mark.slow), "none is there", "osmesa"]
)
def test_where_nothing_can_render_an_error_names_the_packages(backend: str) -> None:
    if backend == "osmesa" and ctypes.util.find_library("OSMesa"):
        pytest.skip("OSMesa is there")

    unset = ("MUJOCO_GL", "PYOPENGL_PLATFORM", "DISPLAY")  # MuJoCo sets the second, too
    environment = {key: value for key, value in os.environ.items() if key not in unset}
    code = "import aicon_envs.arm_push as panda; panda.ArmPushEnv().reset(seed=0)"
    if backend == "none is there":
        hide = "import ctypes.util; ctypes.util.find_library = lambda name: None; "
        code = hide + code
    else:
        environment["MUJOCO_GL"] = backend

    command = [sys.executable, "-c", code]
    result = subprocess.run(
        command, env=environment, capture_output=True, text=True, check=False, timeout=300
    )
    assert result.returncode == 1
    message = result.stderr.strip().splitlines()[-1]
    assert message.startswith("RuntimeError: MuJoCo can") and PACKAGES in message


@needs_rendering
def test_a_picture_larger_than_usual_is_whole() -> None:
    env = ArmPushEnv(obs_type="pose", render_mode="rgb_array", render_width=960, render_height=720)
    env.reset(seed=1)
    picture = env.render()
    assert picture is not None
    for half in (*np.array_split(picture, 2, axis=0), *np.array_split(picture, 2, axis=1)):
        assert half.std() > 10.0
    env.close()


@needs_rendering
def test_the_first_picture_shows_the_target_where_it_is() -> None:
    pictures = []
    for move in (False, True):
        env = ArmPushEnv(obs_type="pose", render_mode="rgb_array")
        env.reset(seed=1, options={"target_pose": None if move else (0.5, -0.2, 2.0)})
        if move:
            env.move_target((0.5, -0.2, 2.0))
        pictures.append(np.asarray(env.render(), dtype=float))
        env.close()
    assert (np.abs(pictures[0] - pictures[1]) > 30.0).any(axis=-1).sum() < 20


@pytest.mark.parametrize("size", [(0, 5), (5, 1.5), "ab"])
def test_the_size_of_a_picture_is_two_counts(size: Any) -> None:
    env = ArmPushEnv(obs_type="pose")
    env.reset(seed=0)
    with pytest.raises(ValueError, match="picture_.* must be an integer >= 1"):
        env.picture("hand", size)
