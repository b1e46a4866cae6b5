"""Whether this machine can render, for the tests of the arm's environment; needs MuJoCo."""

import pytest

from aicon_envs.arm_push import ArmPushEnv


def can_render() -> bool:
    try:
        env = ArmPushEnv()
        env.reset(seed=0)
        env.close()
    except RuntimeError:
        return False
    return True


RENDERS = can_render()
needs_rendering = pytest.mark.skipif(
    not RENDERS, reason="no OpenGL (apt install libegl1 libegl-mesa0 libgl1-mesa-dri)"
)
OBS_TYPES = ["pose", pytest.param("rgbd", marks=needs_rendering)]
