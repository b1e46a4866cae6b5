"""Arms that push: any with a description; one that cannot push is an error that says why."""

from dataclasses import replace
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

pytest.importorskip("aicon_envs.arm_push")

from aicon_envs.arm_push import ARMS, ArmPushEnv
from aicon_envs.reach import ROBOTS, Robot

UR5 = ARMS["ur5"]


@pytest.fixture(scope="module")
def env() -> ArmPushEnv:
    return ArmPushEnv("ur5", obs_type="pose")


@pytest.mark.parametrize("name", ARMS)
@pytest.mark.parametrize("seed", range(3))
def test_episodes_of_every_arm_start_upright_beside_the_object(name: str, seed: int) -> None:
    env = ArmPushEnv(name, obs_type="pose")
    observation, info = env.reset(seed=seed)
    assert observation["q"].shape == env.action_space.shape
    assert info["limit_margin"] > 0.3 and info["self_distance"] >= 0.05 and not info["collision"]
    assert info["tip"][2] == pytest.approx(0.02, abs=1e-3)

    axis = env._simulation.data.body("tool").xmat.reshape(3, 3)[:, 2]
    np.testing.assert_allclose(axis, [0.0, 0.0, -1.0], atol=2e-3)


def test_the_panda_is_the_default_and_has_an_id_of_its_own() -> None:
    usual: Any = gym.make("aicon/ArmPush-v0", obs_type="pose").unwrapped
    panda: Any = gym.make("aicon/ArmPush-v0", obs_type="pose").unwrapped
    assert usual.robot == panda.robot == ARMS["panda"]
    for first, second in zip(usual.reset(seed=3), panda.reset(seed=3), strict=True):
        for key in first:
            np.testing.assert_array_equal(first[key], second[key])


def test_the_reach_of_a_panda_is_that_of_its_straight_arm() -> None:
    """Shoulder to elbow to wrist in a line, from 0.333 m up to 0.427 m, and 0.088 m to the tool."""
    straight = np.hypot(0.316, 0.0825) + np.hypot(0.384, 0.0825)
    reach = np.sqrt(straight**2 - (0.427 - 0.333) ** 2) + 0.088
    description = ArmPushEnv("panda", obs_type="pose").description()
    assert description["reach"] == pytest.approx(reach, abs=1e-3)


def test_the_servos_of_an_arm_without_gains_follow_their_commands(env: ArmPushEnv) -> None:
    env.reset(seed=2)
    velocity = np.array([0.1, -0.1, 0.05, 0.1, -0.05, 0.2])
    before, *_ = [env.step(velocity) for _ in range(50)][-1]  # they lag behind by 0.1 s
    observation, *_ = [env.step(velocity) for _ in range(50)][-1]
    np.testing.assert_allclose(observation["q"] - before["q"], 0.5 * velocity, atol=0.002)


def test_a_joint_that_was_blocked_turns_back_at_once(env: ArmPushEnv) -> None:
    env.reset(seed=2)
    down = np.array([0.0, 0.5, 0.0, 0.0, 0.0, 0.0])
    for _ in range(200):
        blocked, *_, info = env.step(down)
    assert info["collision"]  # the stick on the table

    after, *_ = [env.step(-down) for _ in range(30)][-1]
    assert after["q"][1] < blocked["q"][1] - 0.05


def test_a_robot_that_touches_itself_has_no_gap(env: ArmPushEnv) -> None:
    _, info = env.reset(seed=0)
    simulation = env._simulation
    assert info["self_distance"] > 0.0 and not simulation.collides

    # The elbow folded as far as it goes.
    simulation.data.qpos[2] = 3.1
    env.step(np.zeros(6))
    assert simulation.self_distance < 0.0 and simulation.collides


@pytest.mark.parametrize(
    ("robot", "message"),
    [
        ("pr2", "robot must be a Robot or one of panda, ur5, got 'pr2'"),
        (replace(UR5, tip="hand"), "tip must be a link of ur5_joint_limited_robot.urdf"),
        (replace(UR5, home=(0.0, 1.0)), "home must be 6 finite numbers within the limits"),
        (replace(UR5, home=(9.0,) * 6), "home must be 6 finite numbers within the limits"),
        (replace(UR5, gains=((1.0, 1.0),)), "gains must be one pair for each of 6 joints"),
        (replace(UR5, gains=(1.0,) * 6), "gains must be one pair for each of 6 joints"),
        (replace(UR5, capsules=ARMS["panda"].capsules), "capsules must be a URDF with the joint"),
        (Robot(ROBOTS["so101"].urdf, ROBOTS["so101"].tip), "must be moved by 6 joints or more"),
        (
            Robot(ROBOTS["kinova"].urdf, ROBOTS["kinova"].tip),
            "joint j2s6s200_joint_1 must have lim",
        ),
        (Robot(ROBOTS["tiago"].urdf, ROBOTS["tiago"].tip), "joint torso_lift_joint must turn"),
    ],
)
def test_an_arm_that_cannot_push_says_why(robot: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        ArmPushEnv(robot, obs_type="pose")
