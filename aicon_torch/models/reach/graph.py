"""Reaching: joints, end effector and body of any arm, a target, and what the arm must not do.

An observation has the joints ``q`` ``(*B, n)``, rad or m, ``target_position`` ``(*B, 3)``, m, in
the frame of the base, and, where the orientation matters, ``target_orientation``: the direction of
the tip's axis ``(*B, 3)``, or a quaternion (w, x, y, z) ``(*B, 4)``. Where there are balls,
``ball_1``, ``ball_2``, … are their middles ``(*B, 3)``, m. The action is the velocity of the joints
``(*B, n)``, rad/s or m/s.
"""

import copy
from collections.abc import Callable
from pathlib import Path
from typing import Any

from torch import Tensor

from aicon_torch.errors import OptionError, choices
from aicon_torch.estimation import Deterministic, Estimator, KalmanFilter, Measurement
from aicon_torch.goals import Goal
from aicon_torch.graph import WorldModel
from aicon_torch.interconnections import Affine, Interconnection
from aicon_torch.models.reach.options import Options
from aicon_torch.parts.arrive import Arrive
from aicon_torch.parts.chain import Chain
from aicon_torch.parts.clock import clock
from aicon_torch.parts.end_effector import EndEffector
from aicon_torch.parts.hinge import SquaredHinge
from aicon_torch.parts.joint_limits import JointLimits
from aicon_torch.parts.obstacle import Obstacle, Sphere, moving_point
from aicon_torch.parts.pose_reach import PoseReach
from aicon_torch.parts.robot import Robot
from aicon_torch.parts.self_collision import CapsuleSegments, SelfCollision
from aicon_torch.parts.tip_metric import TipMetric
from aicon_torch.parts.tip_pose import TipPose
from aicon_torch.policy import Policy
from aicon_torch.quantities import Actuator, Sensor

JOINT_NOISE = 1e-4
"""Standard deviation of the encoders, rad."""

JOINT_DRIFT = 1e-6
"""Variance of what moves a joint in a step besides its command, rad²."""

UNKNOWN_JOINT = 10.0
"""Variance of a joint before it is read, rad²."""

BALL_NOISE = 0.002
"""Standard deviation of a ball's position as it is seen, m."""

BALL_DISTANCE = SquaredHinge(margin=0.03, weight=1.0)
"""How far links stay from balls, m, which is their margin where balls are goals like any other:
three times as far as from each other, since a ball may move."""

ANYWHERE = (-100.0, 100.0)
"""Range of angles, places and components of a direction, rad and m."""

MAX_GAP = 2.5
"""Steps without a reading of the joints, the target or a ball after which the arm slows down."""


def build(options: Options) -> Policy:
    """The policy of an arm that reaches."""
    return Policy(world_model(options), options.resolution, options.law)


def world_model(options: Options) -> WorldModel:
    """The graph: joints → end effector → reach, and joints → body → what the body keeps off.

    Raises:
        OptionError: If there is no robot, a joint has no largest speed, or there are balls and the
            robot has no shape.
    """
    robot = _robot(options)
    if options.balls and robot.shape is None:
        raise OptionError(f"balls={options.balls!r}: expected 0, since the robot has no shape.")

    pose = TipPose(options.orientation, options.lever, options.axis)
    end_effector = EndEffector(robot.chain, pose, damping=options.damping)
    return WorldModel(
        sensors=_sensors(options, robot),
        actuators={"a": _actuator(options, robot, end_effector)},
        estimators=_estimators(options, robot, end_effector),
        goals=_goals(options, robot, pose),
        dt=options.dt,
        clock="z_elapsed",
        dtype=options.dtype,
    )


def _robot(options: Options) -> Robot:
    """The robot of the options, a copy of its own for this model."""
    if isinstance(options.robot, Robot):
        return copy.deepcopy(options.robot)
    if isinstance(options.robot, str | Path):
        return Robot.from_urdf(options.robot, tip=options.tip, srdf=options.srdf)
    raise OptionError(
        f"robot={options.robot!r}: expected a URDF, such as 'ur5.urdf', or a Robot of "
        "aicon_torch.models.reach."
    )


def _sensors(options: Options, robot: Robot) -> dict[str, Sensor]:
    """The joints, the target and what is in the way."""
    watched: dict[str, Any] = {"range": ANYWHERE}
    if options.watchdog:
        watched["max_age"] = MAX_GAP * options.dt
    moving = watched | ({"driven_by": "a"} if options.watchdog else {})
    joints = len(robot.chain.names)
    sensors = {
        "z_elapsed": clock(options.dt),
        "z_joints": Sensor(joints, "rad or m", key="q", **moving),
        "z_position": Sensor(3, "m", key="target_position", **watched),
    }

    oriented: dict[str, Any] = {"key": "target_orientation", **watched}
    if options.orientation == "axis":
        sensors["z_orientation"] = Sensor(3, "a direction", **oriented)
    if options.orientation == "full":
        sensors["z_orientation"] = Sensor(4, "a quaternion (w, x, y, z)", **oriented)
    for ball in _balls(options):
        sensors[f"z_{ball}"] = Sensor(3, "m", key=ball, **watched)
    return sensors


def _balls(options: Options) -> tuple[str, ...]:
    """Their names: ``("ball_1", "ball_2", …)``."""
    return tuple(f"ball_{number}" for number in range(1, options.balls + 1))


def _actuator(options: Options, robot: Robot, end_effector: EndEffector) -> Actuator:
    """The velocities of the joints, in proportion within their limits."""
    speeds = _speeds(options, robot.chain)
    typical = sorted(speeds)[(len(speeds) - 1) // 2]
    arrive = Arrive(end_effector, time=options.dampers.braking / typical)
    return Actuator(
        len(speeds),
        "rad/s or m/s",
        limit=speeds,
        keeps_direction=True,
        constraints=[arrive],
        dampers=options.dampers,
        metric=TipMetric(end_effector),
    )


def _speeds(options: Options, chain: Chain) -> tuple[float, ...]:
    """The largest speed of each joint: its own, or that of the options if that is less."""
    speeds = chain.speed if options.speed is None else chain.speed.clamp(max=options.speed)
    if not (speeds > 0).all():
        raise OptionError(
            f"The joints {choices(chain.names)} have the largest speeds {speeds.tolist()}: "
            "expected numbers above 0 (rad/s or m/s)."
        )
    if not speeds.isfinite().all():
        raise OptionError(
            f"speed=None: the robot's description has no largest speed for all of its joints "
            f"({choices(chain.names)}); expected speed=, a number (rad/s)."
        )
    return tuple(speeds.tolist())


def _estimators(options: Options, robot: Robot, end_effector: EndEffector) -> list[Estimator]:
    """Target, joints, end effector, and the body if it has a shape."""
    pose = end_effector.pose
    assert isinstance(pose, TipPose)
    estimators: list[Estimator] = [
        Deterministic("x_target", _target(pose)),
        _joints(options, len(robot.chain.names)),
        Deterministic("x_ee", end_effector),
    ]
    if robot.shape is not None:
        segments = CapsuleSegments(robot.chain, robot.shape.capsules)
        estimators.append(Deterministic("x_body", segments))

    for ball in _balls(options):
        motion = moving_point(f"x_{ball}", f"z_{ball}", options.dt, BALL_NOISE)
        estimators.append(motion)
    return estimators


def _target(pose: TipPose) -> Callable[..., Tensor]:
    """x_target, from what the observation says of it."""
    if pose.orientation == "free":
        return _position_of_target

    def pose_of_target(z_position: Tensor, z_orientation: Tensor) -> Tensor:
        return pose.target(z_position, z_orientation)

    return pose_of_target


def _position_of_target(z_position: Tensor) -> Tensor:
    """x_target where the orientation is free, ``(*B, 3)``, m."""
    return 1.0 * z_position


def _joints(options: Options, count: int) -> KalmanFilter:
    """x_joints: the encoders, filtered."""
    agreement = Affine(x_joints=1.0, z_joints=-1.0)
    return KalmanFilter(
        "x_joints",
        "P_joints",
        predict=Affine(x_joints=1.0, a="dt"),
        noise=JOINT_DRIFT,
        initial=([0.0] * count, UNKNOWN_JOINT),
        correct=[Measurement(agreement, JOINT_NOISE**2, size=count)],
    )


def _goals(options: Options, robot: Robot, pose: TipPose) -> list[Goal]:
    """The target, and what the arm must not do."""
    low, high = robot.chain.low.tolist(), robot.chain.high.tolist()
    limits = JointLimits(low, high, options.joint_limits)
    goals = [
        Goal("reach", PoseReach(pose, options.tolerance)),
        Goal("joint_limits", limits, safety=options.safety),
    ]
    if robot.shape is None:
        return goals

    # The body keeps off the balls and off itself. Itself comes last: where a ball leaves no room
    # for both, it is the wider margin of the ball that gives way.
    capsules, pairs = robot.shape.capsules, robot.shape.pairs
    for ball in _balls(options):
        obstacle = Obstacle(Sphere(options.ball_radius), capsules, BALL_DISTANCE)
        distance = Interconnection(obstacle, inputs=["x_body", f"x_{ball}"])
        goals.append(Goal(ball, distance, safety=options.safety))
    if pairs:
        collision = SelfCollision(capsules, options.self_collision, pairs)
        goals.append(Goal("self_collision", collision, safety=options.safety))
    return goals
