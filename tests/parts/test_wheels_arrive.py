"""Robots on wheels arrive: the loop is closed, with the shared mechanism as it is shipped."""

import pytest
import torch
from _asserts import assert_rows_stand_alone
from _inputs.wheels import (
    BEARING_NOISE,
    CAR,
    DRIVE,
    DT,
    MOTION_NOISE,
    TRUCK,
    WHEELS,
    by_bearing,
    by_pose,
    compiled,
    far_starts,
    noisy,
    range_and_bearing,
    rolled,
    seen,
    starts,
)
from torch import Tensor

from aicon_torch import Actuator, Deterministic, Goal, Policy, Sensor, WorldModel
from aicon_torch.parts import Landmark, Wheels

every_robot = pytest.mark.parametrize(
    "wheels",
    [pytest.param(w, id=n, marks=[pytest.mark.slow] * (w is CAR)) for n, w in WHEELS.items()],
)
ORIGIN = torch.zeros(2, dtype=torch.float64)


def to_the_origin(wheels: Wheels, poses: Tensor, seconds: float, point: str = "ahead") -> Tensor:
    """The poses on the way of robots that know where they are, ``(steps, N, 3)``."""
    policy, memory, way = by_pose(wheels, point), None, [poses]
    for step in range(round(seconds / DT)):
        reading = noisy(way[-1], (0.003, 0.003, 0.003), seed=step)
        action, memory = policy.predict({"z_pose": reading}, memory)
        way.append(rolled(way[-1], wheels.twist(action)))
    return torch.stack(way)


@every_robot
def test_every_robot_arrives_from_everywhere_and_stays(wheels: Wheels) -> None:
    """Six starts around the target, and 58 random ones."""
    way = to_the_origin(wheels, starts(wheels, count=58), seconds=30.0)
    near = 0.02 if wheels is not TRUCK else 0.1
    distances = wheels.point_ahead(way).norm(dim=-1)
    assert (distances[-40:] < near).all()


def test_without_a_point_ahead_most_do_not_arrive() -> None:
    """A goal for the axle has nothing to say of turning: why there is such a point."""
    way = to_the_origin(DRIVE, starts(DRIVE, count=0), seconds=30.0, point="axle")
    arrived = way[-1, :, :2].norm(dim=-1) < 0.1
    assert arrived.sum() <= 2


@pytest.mark.parametrize(
    "wheels",
    [
        pytest.param(DRIVE, id="differential drive"),
        pytest.param(CAR, id="bicycle", marks=pytest.mark.slow),
    ],
)
def test_a_bearing_is_enough(wheels: Wheels) -> None:
    """Where the target is follows from how its bearing changes, in the robot's own axes."""
    poses = far_starts(count=64)
    policy, memory = by_bearing(wheels), None
    nearest = torch.full((len(poses),), torch.inf, dtype=torch.float64)
    for step in range(700):
        bearing = noisy(range_and_bearing(poses, ORIGIN)[:, 1:], (BEARING_NOISE,), seed=step)
        action, memory = policy.predict({"z_tar": bearing}, memory)
        poses = rolled(poses, wheels.twist(action))
        nearest = torch.minimum(nearest, wheels.point_ahead(poses).norm(dim=-1))
    assert (nearest < 0.1).all()


def test_readings_may_be_late() -> None:
    """A reading corrects the belief of when it was taken, which then moves as the robot did."""
    late = Landmark(
        "p_tar",
        "z_tar",
        noise=0.01,
        motion_noise=MOTION_NOISE,
        sees="position",
        delay=5,
        wheels=DRIVE,
    )

    model = WorldModel(
        sensors={"z_tar": Sensor(2, "m", age=4 * DT)},
        actuators={"a": Actuator(2, "m/s", limit=(0.5, 0.5))},
        estimators=[Deterministic("x_rob", DRIVE.motion, is_motion=True), late.estimator()],
        goals=[Goal("reach", late.expected_distance())],
        dt=DT,
        dtype=torch.float64,
    )

    policy, memory, way = compiled(Policy(model)), None, [starts(DRIVE, count=10)]
    for _ in range(300):
        action, memory = policy.predict({"z_tar": seen(way[-5:][0], ORIGIN)}, memory)
        way.append(rolled(way[-1], DRIVE.twist(action)))
    assert (DRIVE.point_ahead(way[-1]).norm(dim=-1) < 0.02).all()


def test_rows_stand_alone() -> None:
    readings = [{"z_pose": starts(CAR, count=2, seed=1000 + step)} for step in range(4)]
    assert_rows_stand_alone(by_pose(CAR), readings, rows=[0, 7])
