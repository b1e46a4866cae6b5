"""Episodes of two arms, from their start to success."""

from typing import Any

import pytest

pytest.importorskip("aicon_envs.panda_push")
pytest.importorskip("trimesh")
pytest.importorskip("pytorch_kinematics")

from aicon_envs.panda_push import ArmPushEnv
from aicon_torch import make_policy
from aicon_torch.models.panda_push import Robot

SIDEWAYS: dict[str, Any] = {"object_pose": (0.52, 0.0, 1.57), "target_pose": (0.52, 0.04, 1.57)}
"""By 4 cm; it takes about 3 s."""


@pytest.mark.parametrize("name", ["panda", "ur5"])
def test_an_arm_pushes_the_object_to_its_target(name: str) -> None:
    env = ArmPushEnv(name, obs_type="pose")
    observation, info = env.reset(seed=1000, options=SIDEWAYS)
    robot = Robot.from_description(env.description())
    policy, memory = make_policy("arm_push", robot=robot, sensing="pose"), None

    for _ in range(1000):
        action, memory = policy.predict(observation, memory)
        observation, _, terminated, _, info = env.step(action)
        assert info["limit_margin"] > 0 and info["self_distance"] > 0 and not info["collision"]
        if terminated:
            break

    assert info["is_success"]
