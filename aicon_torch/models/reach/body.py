"""The body of an arm: its joints, its links, and what it must not do, whatever it is for."""

import copy
from pathlib import Path
from typing import Any

from torch import Tensor

from aicon_torch.errors import OptionError, choices
from aicon_torch.estimation import Deterministic, Estimator
from aicon_torch.goals import Goal
from aicon_torch.graph import WorldModel
from aicon_torch.interconnections import Interconnection
from aicon_torch.models.reach.options import Options
from aicon_torch.models.watched import prompt
from aicon_torch.parts.chain import Chain
from aicon_torch.parts.encoders import joint_filter
from aicon_torch.parts.hinge import SquaredHinge
from aicon_torch.parts.joint_limits import JointLimits
from aicon_torch.parts.obstacle import Obstacle, moving_point
from aicon_torch.parts.robot import Robot
from aicon_torch.parts.self_collision import CapsuleSegments, SelfCollision
from aicon_torch.parts.solids import NUMBERS, Solids, can_be_solids
from aicon_torch.parts.table import Table
from aicon_torch.quantities import Actuator, Sensor
from aicon_torch.validation import numbers

ANYWHERE = (-100.0, 100.0)
"""Range of angles, places and components of a direction, rad and m."""

MAX_GAP = 2.5
"""Steps without a reading of joints, target or obstacle after which the arm slows down."""

BALL_NOISE = 0.002
"""Standard deviation of a ball's position as it is seen, m."""

BALL_DISTANCE = SquaredHinge(margin=0.03, weight=1.0)
"""How far links stay from balls, m, which is their margin where balls are goals like any other:
three times as far as from each other, since a ball may move."""

OBSTACLE_DISTANCE = SquaredHinge(margin=0.004, weight=1.0)
"""How far links stay from objects, m: where there is clutter, targets have little room."""

TABLE_DISTANCE = SquaredHinge(margin=0.01, weight=1.0)
"""How far links stay from a table, m."""


def body_model(options: Options, table: float | None = None) -> WorldModel:
    """The graph of an arm that wants nothing: for a :class:`aicon_torch.Shield`.

    An observation has the joints ``q`` ``(*B, n)``, rad or m, and the balls, if there are any; the
    action ``a`` is the velocity of the joints.

    Args:
        options: The robot, its safety, its watchdog, and what is in its way; what concerns a target
            is not read.
        table: Height of a table in the frame of the base, m; None for no table.

    Raises:
        OptionError: As for :func:`aicon_torch.models.reach.world_model`; also if the robot has no
            shape, the table is no number, or a link cannot keep off it.
    """
    if not isinstance(options, Options):
        raise OptionError(
            f"options={options!r}: expected Options, such as Options(robot='ur5.urdf', speed=1.0)."
        )
    if table is not None:
        (table,) = numbers("table", table, 1)
    robot = robot_of(options)
    if robot.shape is None:
        raise OptionError("robot: it has no shape, so a shield could keep its stops alone.")

    count = len(robot.chain.names)
    speeds = speeds_of(options, robot.chain)
    velocity = Actuator(
        count, "rad/s or m/s", speeds, keeps_direction=True, dampers=options.dampers
    )
    return WorldModel(
        sensors={"z_joints": joint_sensor(options, robot), **obstacle_sensors(options)},
        actuators={"a": velocity},
        estimators=[joint_filter([0.0] * count), body(robot), *ball_estimators(options)],
        goals=bounds(options, robot, table),
        dt=options.dt,
        dtype=options.dtype,
    )


def towards(proposal: Tensor, x_joints: Tensor, dt: Tensor) -> Tensor:
    """The velocity ``(*B, n)`` that takes the joints in one step where a policy proposes."""
    return (proposal - x_joints) / dt


def robot_of(options: Options) -> Robot:
    """The robot of the options, a copy of its own for this model."""
    if isinstance(options.robot, Robot):
        for name in ("tip", "srdf"):
            if getattr(options, name) is not None:
                raise OptionError(
                    f"{name}={getattr(options, name)!r}: expected None, since the robot is no URDF "
                    "but a Robot already: Robot.from_urdf takes it."
                )
        return copy.deepcopy(options.robot)

    if isinstance(options.robot, str | Path):
        return Robot.from_urdf(options.robot, tip=options.tip, srdf=options.srdf)
    raise OptionError(
        f"robot={options.robot!r}: expected a URDF, such as 'ur5.urdf', or a Robot of "
        "aicon_torch.models.reach."
    )


def speeds_of(options: Options, chain: Chain) -> tuple[float, ...]:
    """The largest speed of each joint: its own, or that of the options if that is less."""
    speeds = chain.speed if options.speed is None else chain.speed.clamp(max=options.speed)
    still = [name for name, speed in zip(chain.names, speeds, strict=True) if not speed > 0]
    if still:
        raise OptionError(
            f"The joints {choices(still)} have the largest speed 0 in the robot's description: "
            "expected velocity= above 0 in their <limit> (rad/s or m/s), or joints of "
            "type='fixed'."
        )

    if not speeds.isfinite().all():
        pairs = zip(chain.names, speeds, strict=True)
        without = [name for name, speed in pairs if not speed.isfinite()]
        raise OptionError(
            f"speed=None: the robot's description has no largest speed for {choices(without)}; "
            "expected velocity= in its <limit>, or speed=, a number that no joint then exceeds "
            "(rad/s or m/s)."
        )
    return tuple(speeds.tolist())


def body(robot: Robot) -> Deterministic:
    """x_body: the capsules of the links, in the frame of the base."""
    assert robot.shape is not None
    return Deterministic("x_body", CapsuleSegments(robot.chain, robot.shape.capsules))


def watched(options: Options) -> dict[str, Any]:
    """What every sensor has: a range, and with the watchdog an age from which on the arm slows."""
    return {"range": ANYWHERE, **prompt(options.dt, MAX_GAP if options.watchdog else None)}


def joint_sensor(options: Options, robot: Robot) -> Sensor:
    """Where the joints are; with the watchdog they must change while the arm moves."""
    driven_by = "a" if options.watchdog else None
    count = len(robot.chain.names)
    return Sensor(count, "rad or m", key="q", driven_by=driven_by, **watched(options))


def obstacle_sensors(options: Options) -> dict[str, Sensor]:
    """Where each ball is seen, and the objects."""
    checks = watched(options)
    sensors = {f"z_{ball}": Sensor(3, "m", key=ball, **checks) for ball in _balls(options)}
    if options.obstacles:
        size = options.obstacles * NUMBERS
        sensors["z_obstacles"] = Sensor(
            size, "m and others", key="obstacles", is_possible=can_be_solids, **checks
        )
    return sensors


def ball_estimators(options: Options) -> list[Estimator]:
    """Where each ball is, and how fast."""
    return [
        moving_point(f"x_{ball}", f"z_{ball}", options.dt, BALL_NOISE) for ball in _balls(options)
    ]


def bounds(options: Options, robot: Robot, table: float | None = None) -> list[Goal]:
    """What the arm must not do: pass its stops, touch the table, balls, objects, or itself."""
    limits = JointLimits(robot.chain.low, robot.chain.high, options.joint_limits)
    goals = [Goal("joint_limits", limits, safety=options.safety)]
    if robot.shape is None:
        return goals

    if table is not None:
        below = Table.under(robot, table, TABLE_DISTANCE)
        goals.append(Goal("table", below, safety=options.safety))
    for ball in _balls(options):
        obstacle = Obstacle(options.ball_radius, robot.shape.capsules, BALL_DISTANCE)
        distance = Interconnection(obstacle, inputs=["x_body", f"x_{ball}"])
        goals.append(Goal(ball, distance, safety=options.safety))
    if options.obstacles:
        solids = Solids(robot.chain, robot.shape.capsules, options.obstacles, OBSTACLE_DISTANCE)
        distance = Interconnection(solids, inputs=["x_joints", "z_obstacles"])
        goals.append(Goal("obstacles", distance, safety=options.safety))
    if robot.shape.pairs:
        shape, chain = robot.shape, robot.chain
        collision = SelfCollision(shape.capsules, options.self_collision, shape.pairs, chain)
        distance = Interconnection(collision, inputs=["x_joints"])
        goals.append(Goal("self_collision", distance, safety=options.safety))
    return goals


def _balls(options: Options) -> tuple[str, ...]:
    """Their names: ``("ball_1", "ball_2", …)``."""
    return tuple(f"ball_{number}" for number in range(1, options.balls + 1))
