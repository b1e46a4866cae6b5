"""Robots on wheels in a plane: how they move, what they see, and graphs that steer them."""

import functools
import math

import torch
from torch import Tensor

from _inputs.random_numbers import normal
from aicon_torch import Actuator, Deterministic, Goal, Policy, Sensor, WorldModel
from aicon_torch.export.codegen import has_compiler
from aicon_torch.parts import (
    BearingPrior,
    Bicycle,
    DifferentialDrive,
    Landmark,
    MovingObstacle,
    Wheels,
    rotate,
)

DT = 0.05  # s

DRIVE, CAR = DifferentialDrive(track=0.3), Bicycle(wheelbase=0.3)
TRUCK = Bicycle(wheelbase=2.5)
WHEELS: dict[str, Wheels] = {"differential drive": DRIVE, "bicycle": CAR, "truck": TRUCK}
LIMITS = {DRIVE: (0.5, 0.5), CAR: (0.5, 0.6), TRUCK: (2.0, 0.5)}

BEARING_NOISE, RANGE_NOISE = 0.02, 0.02  # rad, m
MOTION_NOISE = 0.0003  # m
RADIUS = 0.5  # of the robot and the obstacle together, m


def rolled(pose: Tensor, twist: Tensor, dt: float = DT) -> Tensor:
    """Where wheels that do not slip bring a robot, ``(*B, 3)``: along an arc."""
    half_turn = twist[..., 1] * dt / 2
    chord = twist[..., 0] * dt * torch.sinc(half_turn / math.pi)
    direction = pose[..., 2] + half_turn
    change = (chord * direction.cos(), chord * direction.sin(), 2 * half_turn)
    return pose + torch.stack(change, dim=-1)


def seen(pose: Tensor, place: Tensor) -> Tensor:
    """A place in the axes of a robot, ``(*B, 2)``, m."""
    return rotate(place - pose[..., :2], -pose[..., 2])


def range_and_bearing(pose: Tensor, place: Tensor) -> Tensor:
    """The same as ``(*B, 2)``, m and rad."""
    x, y = seen(pose, place).unbind(-1)
    return torch.stack((torch.hypot(x, y), torch.atan2(y, x)), dim=-1)


def starts(wheels: Wheels, count: int, seed: int = 1000) -> Tensor:
    """Six poses around the origin, two metres away, and random ones, ``(6 + count, 3)``.

    A large robot stands farther away, as its limits are larger.
    """
    around = torch.arange(6, dtype=torch.float64)
    headings = torch.tensor([0.0, 1.5, 3.0, -1.5, 2.5, -2.5], dtype=torch.float64)
    six = torch.stack((2.0 * around.cos(), 2.0 * around.sin(), headings), dim=-1)

    generator = torch.Generator().manual_seed(seed)
    shares = 2.0 * torch.rand(count, 3, generator=generator, dtype=torch.float64) - 1.0
    poses = torch.cat((six, shares * torch.tensor([3.0, 3.0, math.pi])))
    size = 8.0 if wheels is TRUCK else 1.0
    return poses * torch.tensor([size, size, 1.0], dtype=torch.float64)


def far_starts(count: int, seed: int = 1000) -> Tensor:
    """Random poses, three to seven metres from the origin, ``(count, 3)``."""
    generator = torch.Generator().manual_seed(seed)
    shares = torch.rand(count, 3, generator=generator, dtype=torch.float64)
    distance, direction = 3.0 + 4.0 * shares[:, :1], 2 * math.pi * shares[:, 1]
    place = rotate(torch.cat((distance, torch.zeros_like(distance)), dim=-1), direction)
    return torch.cat((place, 2 * math.pi * shares[:, 2:]), dim=-1)


def compiled(policy: Policy) -> Policy:
    """Compiled where there is a compiler."""
    return policy.compile() if has_compiler() else policy


@functools.cache
def by_pose(wheels: Wheels, point: str = "ahead") -> Policy:
    """A robot that knows its pose and is to bring a point of itself to the origin."""

    def of_axle(x_pose: Tensor) -> Tensor:
        return x_pose[..., :2]

    pose = wheels.pose_estimator("x_pose", "z_pose", (0.01, 0.01, 0.01), MOTION_NOISE)
    place = wheels.point_ahead if point == "ahead" else of_axle
    model = WorldModel(
        sensors={"z_pose": Sensor(3, "m, m and rad")},
        actuators={"a": Actuator(2, "m/s, or m/s and rad", limit=LIMITS[wheels])},
        estimators=[
            Deterministic("x_rob", wheels.motion, is_motion=True),
            pose,
            Deterministic("x_point", place),
        ],
        goals=[Goal("reach", lambda x_point: x_point.norm(dim=-1))],
        dt=DT,
        dtype=torch.float64,
    )
    return compiled(Policy(model))


@functools.cache
def by_bearing(wheels: Wheels) -> Policy:
    """A robot that sees where its target is, and nothing else."""
    target = Landmark(
        "p_tar",
        "z_tar",
        noise=BEARING_NOISE,
        motion_noise=MOTION_NOISE,
        prior=BearingPrior(distance=5.0, across=0.15, along=2.0),
        wheels=wheels,
    )
    model = WorldModel(
        sensors={"z_tar": Sensor(1, "rad")},
        actuators={"a": Actuator(2, "m/s, or m/s and rad", limit=LIMITS[wheels])},
        estimators=[Deterministic("x_rob", wheels.motion, is_motion=True), target.estimator()],
        goals=[Goal("reach", target.expected_distance())],
        dt=DT,
        dtype=torch.float64,
    )
    return compiled(Policy(model))


def person(wheels: Wheels | None) -> MovingObstacle:
    """Somebody who walks."""
    return MovingObstacle(
        "x_person",
        "z_person",
        range_noise=RANGE_NOISE,
        bearing_noise=BEARING_NOISE,
        motion_noise=MOTION_NOISE,
        dt=DT,
        wheels=wheels,
    )


@functools.cache
def among_people(wheels: Wheels) -> Policy:
    """The same, and somebody walks there."""
    walking = person(wheels)
    likelihood = walking.collision_likelihood(radius=RADIUS, length=0.1, horizon=4.0)
    policy = by_bearing(wheels).with_estimator(walking.estimator(), z_person=Sensor(2, "m, rad"))
    return policy.with_goal(Goal("avoid", likelihood))


def noisy(readings: Tensor, deviation: tuple[float, ...], seed: int) -> Tensor:
    """Readings as an instrument tells them."""
    return readings + readings.new_tensor(deviation) * normal(*readings.shape, seed=seed)
