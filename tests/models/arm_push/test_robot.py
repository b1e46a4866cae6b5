import re

import numpy as np
import pytest
from _inputs.arm import panda, postures

from aicon_torch import OptionError, make_policy
from aicon_torch.models.arm_push import PANDA, Options, PushingRobot, end_effector
from aicon_torch.parts.camera import Intrinsics
from aicon_torch.parts.hinge import SquaredHinge
from aicon_torch.parts.self_collision import Capsule, CapsuleSegments, SelfCollision

ROWS = np.eye(4).tolist()
PLAIN = {
    "frames": [ROWS, ROWS],
    "tool": ROWS,
    "camera": ROWS,
    "intrinsics": (80.0, 1.0, 2.0, 3.0, 4.0),
    "low": (-1.0, -1.0),
    "high": (1.0, 1.0),
    "speed": (2.0, 2.0),
    "capsules": [(0, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.1)],
    "stick_length": 0.3,
    "stick_radius": 0.01,
    "tool_mass": 0.2,
    "reach": 0.8,
    "nearest": 0.3,
}
"""A robot of two joints as an environment describes it."""


def test_the_robot_is_that_of_the_physics():
    arm_push = pytest.importorskip("aicon_envs.arm_push")
    robot = PushingRobot.from_description(arm_push.ArmPushEnv(obs_type="pose").description())
    for name, value in robot.chain.state_dict().items():
        np.testing.assert_allclose(value, PANDA.chain.state_dict()[name], atol=1e-6)
    for name in ("camera", "intrinsics"):
        np.testing.assert_allclose(getattr(robot, name), getattr(PANDA, name), atol=1e-6)
    assert robot.tool_mass == PANDA.tool_mass and robot.shape.pairs == PANDA.shape.pairs
    assert robot.reach == PANDA.reach


def test_the_tip_and_the_gap_of_the_body_are_those_of_the_physics():
    arm_push = pytest.importorskip("aicon_envs.arm_push")
    import mujoco

    env = arm_push.ArmPushEnv(obs_type="pose")
    robot = PushingRobot.from_description(env.description())
    simulation, arm = env._simulation, panda()
    segments = CapsuleSegments(arm.chain, robot.shape.capsules)
    goal = SelfCollision(robot.shape.capsules, SquaredHinge(margin=0.05, weight=1.0))
    for q in postures(5):
        simulation.data.qpos[:7] = q.numpy()
        mujoco.mj_kinematics(simulation.model, simulation.data)
        np.testing.assert_allclose(arm(q)[:3], simulation.data.site("tip").xpos, atol=1e-9)
        gap = goal.distances(segments(q)).min()
        np.testing.assert_allclose(gap, simulation.self_distance, atol=1e-8)


@pytest.mark.slow
def test_the_tip_of_another_arm_is_that_of_the_physics_and_its_capsules_enclose_its_shape():
    arm_push = pytest.importorskip("aicon_envs.arm_push")
    pytest.importorskip("trimesh")
    pytest.importorskip("pytorch_kinematics")
    import mujoco
    import torch

    env = arm_push.ArmPushEnv("ur5", obs_type="pose")
    robot = PushingRobot.from_description(env.description())
    assert {capsule.link for capsule in robot.shape.capsules} == set(range(8))

    simulation, arm = env._simulation, end_effector(Options(robot=robot))
    segments = CapsuleSegments(arm.chain, robot.shape.capsules)
    goal = SelfCollision(
        robot.shape.capsules, SquaredHinge(margin=0.05, weight=1.0), robot.shape.pairs
    )
    for seed in range(20):
        q = 2.0 * torch.randn(6, generator=torch.Generator().manual_seed(seed)).double()
        simulation.data.qpos[:6] = q.numpy()
        mujoco.mj_kinematics(simulation.model, simulation.data)
        np.testing.assert_allclose(arm(q)[:3], simulation.data.site("tip").xpos, atol=1e-9)
        seen = goal.distances(segments(q)).min().clamp(max=0.05)  # as far as the physics look
        assert seen <= simulation.self_distance + 1e-3


def test_a_description_gives_plain_numbers():
    robot = PushingRobot.from_description(PLAIN)
    assert robot.chain.names == ("joint_1", "joint_2")
    assert isinstance(robot.intrinsics, Intrinsics) and isinstance(robot.shape.capsules[0], Capsule)
    assert robot.chain.low.tolist() == [-1.0, -1.0]


def test_joints_turn_about_their_axes():
    quarter = np.array([np.pi / 2, 0.0])
    about_z, about_x = (
        PushingRobot.from_description(PLAIN | {"axes": axes}).chain
        for axes in (None, ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0)))
    )
    q = about_z.low.new_tensor(quarter)
    np.testing.assert_allclose(about_z(q)[:3, 0], [0.0, 1.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(about_x(q)[:3, 1], [0.0, 0.0, 1.0], atol=1e-12)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"reach": None}, "description of the robot lacks 'reach'"),
        ({"payload": 3.0}, "description of the robot has 'payload': expected 'frames', 'low'"),
        ({"low": (-1.0,)}, "robot.low has 1 of them: expected 2, as robot.frames"),
        ({"axes": ((0.0, 0.0, 1.0),)}, "robot.axes has 1 of them: expected 2"),
        ({"high": 1.0}, "robot.high has 0 of them: expected 2, as robot.frames"),
        ({"frames": 2}, "robot.frames=2: expected three rows of four finite numbers for each"),
        ({"tool": ROWS[:2]}, "expected three rows of four finite numbers."),
        ({"camera": "hand"}, "robot.camera='hand': expected three rows of four finite numbers."),
        ({"camera": np.full((4, 4), np.nan)}, "expected three rows of four finite numbers."),
        ({"intrinsics": (80.0, 1.0)}, "intrinsics=(80.0, 1.0): expected 5 finite numbers"),
        ({"stick_length": np.nan}, "stick_length=nan: expected 1 finite number"),
        ({"stick_radius": -0.01}, "stick_radius=-0.01: expected a positive number"),
        ({"tool_mass": "heavy"}, "tool_mass='heavy': expected 1 finite number"),
        ({"nearest": -1.0}, "nearest=-1.0: expected a number >= 0"),
    ],
)
def test_what_a_description_lacks_is_named(changes, message):
    description = {key: value for key, value in (PLAIN | changes).items() if value is not None}
    with pytest.raises(OptionError, match=re.escape(message)):
        PushingRobot.from_description(description)


def test_a_robot_that_is_none_is_named():
    with pytest.raises(OptionError, match="robot='ur5': expected a PushingRobot, such as Pushing"):
        make_policy("arm_push", robot="ur5", sensing="pose")
