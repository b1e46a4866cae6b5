"""Reaching: joints, end effector and body of any arm, a target, and what the arm must not do.

An observation has the joints ``q`` ``(*B, n)``, rad or m, ``target_position`` ``(*B, 3)``, m, in
the frame of the base, and, where the orientation matters, ``target_orientation``: the direction of
the tip's axis ``(*B, 3)``, or a quaternion (w, x, y, z) ``(*B, 4)``. Where there are balls,
``ball_1``, ``ball_2``, … are their middles ``(*B, 3)``, m; where there are objects, ``obstacles``
are their numbers ``(*B, 16 N)``, see :class:`aicon_torch.parts.Solid`. The action is the velocity
of the joints ``(*B, n)``, rad/s or m/s.
"""

from collections.abc import Callable
from typing import Any

from torch import Tensor

from aicon_torch.errors import OptionError
from aicon_torch.estimation import Deterministic, Estimator
from aicon_torch.goals import Goal
from aicon_torch.graph import WorldModel
from aicon_torch.interconnections import Interconnection
from aicon_torch.models.reach.body import (
    ball_estimators,
    body,
    bounds,
    joint_sensor,
    obstacle_sensors,
    robot_of,
    speeds_of,
    watched,
)
from aicon_torch.models.reach.options import Options
from aicon_torch.parts.approach import Approach, ToolAxis
from aicon_torch.parts.arrive import Arrive
from aicon_torch.parts.clock import clock
from aicon_torch.parts.encoders import joint_filter
from aicon_torch.parts.end_effector import EndEffector
from aicon_torch.parts.pose_reach import PoseReach
from aicon_torch.parts.robot import Robot
from aicon_torch.parts.tip_metric import TipMetric
from aicon_torch.parts.tip_pose import TipPose
from aicon_torch.policy import Policy
from aicon_torch.quantities import Actuator, Sensor


def build(options: Options) -> Policy:
    """The policy of an arm that reaches."""
    return Policy(world_model(options), options.resolution, options.law)


def world_model(options: Options) -> WorldModel:
    """The graph: joints → end effector → reach, and joints → body → what the body keeps off.

    Raises:
        OptionError: If there is no robot, a joint has no largest speed, or there are balls and the
            robot has no shape.
    """
    robot = robot_of(options)
    for name in ("balls", "obstacles"):
        if getattr(options, name) and robot.shape is None:
            number = getattr(options, name)
            raise OptionError(f"{name}={number!r}: expected 0, since the robot has no shape.")

    pose = TipPose(options.orientation, options.lever, options.axis)
    end_effector = EndEffector(
        robot.chain,
        pose,
        damping=options.damping,
        turns_within=options.turns_within,
        advance=_advance(options, pose),
    )
    return WorldModel(
        sensors=_sensors(options, robot),
        actuators={"a": _actuator(options, robot, end_effector)},
        estimators=_estimators(options, robot, pose, end_effector),
        goals=[Goal("reach", PoseReach(pose, options.tolerance)), *bounds(options, robot)],
        dt=options.dt,
        clock="z_elapsed",
        dtype=options.dtype,
    )


def _advance(options: Options, pose: TipPose) -> ToolAxis | None:
    """How an advance along the axis of the tool counts; a target may have none."""
    if options.advances_within is None or options.orientation == "free":
        return None
    return ToolAxis(pose, options.advances_within)


def _sensors(options: Options, robot: Robot) -> dict[str, Sensor]:
    """The joints, the target and what is in the way."""
    checks = watched(options)
    sensors = {
        "z_elapsed": clock(),
        "z_joints": joint_sensor(options, robot),
        "z_position": Sensor(3, "m", key="target_position", **checks),
    }

    # An orientation comes as an axis, or as a whole rotation.
    oriented: dict[str, Any] = {"key": "target_orientation", **checks}
    if options.orientation == "axis":
        sensors["z_orientation"] = Sensor(3, "a direction", **oriented)
    if options.orientation == "full":
        sensors["z_orientation"] = Sensor(4, "a quaternion (w, x, y, z)", **oriented)
    return sensors | obstacle_sensors(options)


def _actuator(options: Options, robot: Robot, end_effector: EndEffector) -> Actuator:
    """The velocities of the joints, in proportion within their limits."""
    speeds = speeds_of(options, robot.chain)
    arrive = Arrive(end_effector, time=options.arrives_within / _typical(speeds))
    return Actuator(
        len(speeds),
        "rad/s or m/s",
        limit=speeds,
        keeps_direction=True,
        constraints=[arrive],
        dampers=options.dampers,
        metric=Interconnection(TipMetric(end_effector), _of_tip(options)),
    )


def _typical(speeds: tuple[float, ...]) -> float:
    """Their median, or the lower of two."""
    return sorted(speeds)[(len(speeds) - 1) // 2]


def _estimators(
    options: Options, robot: Robot, pose: TipPose, end_effector: EndEffector
) -> list[Estimator]:
    """Target, joints, end effector, and the body if it has a shape."""
    estimators: list[Estimator] = [
        Deterministic("x_target", _target(pose)),
        joint_filter([0.0] * len(robot.chain.names)),
    ]

    # The tip, on its way to the target; along the axis of its tool if the direct way is closed.
    of_tip = _of_tip(options)
    if end_effector.advance is not None:
        typical = _typical(speeds_of(options, robot.chain))
        estimators.append(Approach(robot.chain, pose, typical))
        of_tip = ["x_joints", "x_target", "x_approach"]
    estimators.append(Deterministic("x_ee", Interconnection(end_effector, of_tip)))

    if robot.shape is not None:
        estimators.append(body(robot))
    return estimators + ball_estimators(options)


def _of_tip(options: Options) -> list[str]:
    """What the motion of the tip is computed from: of its target where its turns wait."""
    return ["x_joints"] if options.turns_within is None else ["x_joints", "x_target"]


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
