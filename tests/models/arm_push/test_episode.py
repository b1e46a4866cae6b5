"""Episodes of two arms, from their start."""

from typing import Any

import pytest

pytest.importorskip("aicon_envs.arm_push")

from _inputs import driven

from aicon_envs.arm_push import ArmPushEnv
from aicon_torch.models.arm_push import PushingRobot

SIDEWAYS: dict[str, Any] = {"object_pose": (0.52, 0.0, 1.57), "target_pose": (0.52, 0.04, 1.57)}
"""By 4 cm; a Panda needs about 3 s."""


def push(name: str, steps: int, distance: float) -> dict[str, Any]:
    """What an arm has done when the object is so near its target, or after so many steps."""
    env = ArmPushEnv(name, obs_type="pose")
    observation, info = env.reset(seed=1000, options=SIDEWAYS)
    other = {} if name == "panda" else {"robot": PushingRobot.from_description(env.description())}
    policy, memory = driven("arm_push", sensing="pose", **other), None

    for _ in range(steps):
        action, memory = policy.predict(observation, memory)
        observation, _, terminated, _, info = env.step(action)
        assert info["limit_margin"] > 0 and info["self_distance"] > 0 and not info["collision"]
        if terminated or info["distance"] < distance:
            break
    return info


def test_it_pushes_the_object_to_its_target() -> None:
    assert push("panda", steps=1000, distance=0.0)["is_success"]


@pytest.mark.slow
def test_another_arm_pushes_the_object_half_the_way() -> None:
    pytest.importorskip("trimesh")
    pytest.importorskip("pytorch_kinematics")
    info = push("ur5", steps=400, distance=0.02)
    assert info["distance"] < 0.02
    assert info["tip"][2] == pytest.approx(0.02, abs=0.005)
