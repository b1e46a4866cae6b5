import numpy as np
import pytest
from _inputs.arm import panda, postures

from aicon_torch.models.panda_push import PANDA, Robot
from aicon_torch.parts.camera import Intrinsics
from aicon_torch.parts.hinge import SquaredHinge
from aicon_torch.parts.self_collision import Capsule, CapsuleSegments, SelfCollision


def test_the_robot_is_that_of_the_physics():
    panda_push = pytest.importorskip("aicon_envs.panda_push")
    robot = Robot.from_description(panda_push.PandaPushEnv(obs_type="pose").description())
    for name in ("frames", "tool", "camera", "intrinsics", "low", "high", "speed"):
        np.testing.assert_allclose(getattr(robot, name), getattr(PANDA, name), atol=1e-6)
    assert robot.tool_mass == PANDA.tool_mass and len(robot.capsules) == len(PANDA.capsules)


def test_the_tip_and_the_gap_of_the_body_are_those_of_the_physics():
    panda_push = pytest.importorskip("aicon_envs.panda_push")
    import mujoco

    env = panda_push.PandaPushEnv(obs_type="pose")
    robot = Robot.from_description(env.description())
    simulation, arm = env._simulation, panda()
    segments = CapsuleSegments(arm.chain, robot.capsules)
    goal = SelfCollision(robot.capsules, SquaredHinge(margin=0.05, weight=1.0))
    for q in postures(5):
        simulation.data.qpos[:7] = q.numpy()
        mujoco.mj_kinematics(simulation.model, simulation.data)
        np.testing.assert_allclose(arm(q)[:3], simulation.data.site("tip").xpos, atol=1e-9)
        gap = goal.distances(segments(q)).min()
        np.testing.assert_allclose(gap, simulation.self_distance, atol=1e-8)


def test_a_description_gives_plain_numbers_and_the_rest_is_a_pandas():
    rows = np.eye(4).tolist()
    description = {
        "frames": [rows, rows],
        "tool": rows,
        "camera": rows,
        "intrinsics": (80.0, 1.0, 2.0, 3.0, 4.0),
        "capsules": [(0, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.1)],
        "low": (-1.0, -1.0),
    }
    robot = Robot.from_description(description)
    assert len(robot.frames) == 2 and len(robot.tool) == 3
    assert isinstance(robot.intrinsics, Intrinsics) and isinstance(robot.capsules[0], Capsule)
    assert robot.low == (-1.0, -1.0) and robot.stick_length == PANDA.stick_length
