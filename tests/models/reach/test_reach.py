"""An arm reaches its targets within its limits, whatever arm it is."""

import functools

import pytest
import torch
from _inputs import lean, quick
from _inputs.reaching import DT, planar_arm, reach, targets_of

from aicon_torch import make_policy
from aicon_torch.models.reach import Robot
from aicon_torch.parts import Obstacle, SelfCollision, SquaredHinge
from aicon_torch.parts.self_collision import CapsuleSegments

ARMS = ("panda", *(pytest.param(name, marks=pytest.mark.slow) for name in ("ur5", "xarm7")))


@functools.cache
def arm(name: str) -> Robot:
    """A robot of example-robot-data, without its shape."""
    robots = pytest.importorskip("_inputs.robots", exc_type=ImportError)
    files = robots.ROBOTS[name]
    return Robot.from_urdf(robots.robot_file(files.urdf), tip=files.tip, collisions=False)


@pytest.mark.parametrize("name", ARMS)
def test_an_arm_reaches_positions_within_its_limits(name: str) -> None:
    pytest.importorskip("pytorch_kinematics")
    robot, targets = arm(name), targets_of(arm(name), 6, seed=3)[:, :3, 3]
    policy = quick(make_policy("reach", robot=robot, speed=1.5))
    start = (robot.chain.low.clamp(min=-3) + robot.chain.high.clamp(max=3)) / 2

    way, _ = reach(policy, start.expand(6, -1), seconds=8, target_position=targets)
    found = robot.chain(way[-1])[:, :3, 3]
    assert ((found - targets).norm(dim=-1) < 0.01).sum() >= 5
    assert (way > robot.chain.low).all()
    assert (way < robot.chain.high).all()
    assert (way.diff(dim=0).abs() <= 1.5 * DT + 1e-9).all()


@pytest.mark.parametrize("name", [pytest.param("panda", marks=pytest.mark.slow), "ur5"])
def test_an_arm_reaches_a_pose_near_by(name: str) -> None:
    pytest.importorskip("pytorch_kinematics")
    robot = arm(name)
    start = torch.tensor([0.1, -0.8, 0.4, -2.0, 0.3, 1.5, 0.2][: len(robot.chain.names)])
    target = robot.chain(start.double() + 0.3)

    policy = quick(make_policy("reach", robot=robot, orientation="axis", speed=1.5))
    way, _ = reach(
        policy,
        start.double(),
        seconds=4,
        target_position=target[:3, 3],
        target_orientation=target[:3, 2],
    )
    tip = robot.chain(way[-1])
    torch.testing.assert_close(tip[:3, 3], target[:3, 3], rtol=0, atol=2e-3)
    torch.testing.assert_close(tip[:3, 2], target[:3, 2], rtol=0, atol=2e-2)


def test_a_pose_is_a_position_and_a_quaternion() -> None:
    robot = planar_arm(links=4, shape=False)
    policy = quick(make_policy("reach", robot=robot, orientation="full"))
    angle = torch.tensor(1.2, dtype=torch.float64)
    zero = torch.zeros_like(angle)
    quaternion = torch.stack((torch.cos(angle / 2), zero, zero, torch.sin(angle / 2)))
    position = torch.tensor([0.5, 0.6, 0.0], dtype=torch.float64)

    start = torch.tensor([0.2, 0.3, 0.3, 0.3], dtype=torch.float64)
    way, _ = reach(
        policy, start, seconds=5, target_position=position, target_orientation=quaternion
    )
    tip = robot.chain(way[-1])
    torch.testing.assert_close(tip[:3, 3], position, rtol=0, atol=2e-3)
    assert torch.atan2(tip[1, 0], tip[0, 0]) == pytest.approx(1.2, abs=0.02)


def test_an_arm_never_touches_itself() -> None:
    robot = planar_arm(links=5)
    assert robot.shape is not None
    segments = CapsuleSegments(robot.chain, robot.shape.capsules)
    distance = SelfCollision(robot.shape.capsules, SquaredHinge(1.0, 1.0), robot.shape.pairs)
    policy = quick(make_policy("reach", robot=robot))

    start = torch.full((12, 5), 0.3, dtype=torch.float64)
    targets = targets_of(robot, 12, seed=1)[:, :3, 3]
    way, _ = reach(policy, start, seconds=4, target_position=targets)
    assert distance.distances(segments(way)).min() > 0.005


def test_an_arm_as_many_times_as_fast_takes_the_same_way() -> None:
    target = torch.tensor([-0.3, 0.5, 0.0], dtype=torch.float64)
    start = torch.tensor([0.5, 0.5, 0.5], dtype=torch.float64)
    ways = []
    for factor in (1, 3):
        policy = lean("reach", robot=planar_arm(1.5 * factor), dt=DT / factor)
        way, _ = reach(policy, start, 0.6 / factor, DT / factor, target_position=target)
        ways.append(way)
    torch.testing.assert_close(*ways, rtol=0, atol=1e-5)


@pytest.mark.parametrize("ball_speed", [pytest.param(0.0, marks=pytest.mark.slow), 0.3])
def test_an_arm_gives_way_to_a_ball(ball_speed: float) -> None:
    robot = planar_arm()
    assert robot.shape is not None
    policy = quick(make_policy("reach", robot=robot, balls=1, ball_radius=0.05))
    segments = CapsuleSegments(robot.chain, robot.shape.capsules)
    distance = Obstacle(0.05, robot.shape.capsules, SquaredHinge(1.0, 1.0))

    q = torch.tensor([0.6, 0.8, 0.6], dtype=torch.float64)
    target = robot.chain(q)[:3, 3]
    start = target + torch.tensor([0.8, 0.05, 0.0], dtype=torch.float64)
    if ball_speed == 0:
        start, q = target + 0.0, q - 0.5

    memory, nearest = None, 9.0
    for step in range(200):
        away = torch.tensor([ball_speed * step * DT, 0.0, 0.0], dtype=torch.float64)
        ball = start - away
        observation = {"q": q, "target_position": target, "ball_1": ball}
        action, memory = policy.predict(observation, memory)
        q = q + DT * action
        nearest = min(nearest, float(distance.distances(segments(q), ball).min()))
    assert nearest > 0.01
