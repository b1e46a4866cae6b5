"""An obstacle by range and bearing: where it is, how it moves, and what is kept from it."""

import math
import pickle

import pytest
import torch
from _asserts import assert_rows_stand_alone
from _inputs import normal
from _inputs.wheels import (
    BEARING_NOISE,
    CAR,
    DRIVE,
    DT,
    RADIUS,
    RANGE_NOISE,
    among_people,
    by_bearing,
    noisy,
    person,
    range_and_bearing,
    rolled,
)
from torch import Tensor

from aicon_torch import Actuator, Deterministic, Goal, Policy, Sensor, WorldModel
from aicon_torch.errors import OptionError
from aicon_torch.parts import MovingObstacle, Wheels, rotate
from aicon_torch.parts.moving_obstacle import GapToCome

NOISE = (RANGE_NOISE, BEARING_NOISE)
TARGET = torch.tensor([5.0, 0.0], dtype=torch.float64)


def spine_gap(wheels: Wheels, pose: Tensor, place: Tensor) -> Tensor:
    """From the robot, axle to point ahead, to an obstacle, ``(*B,)``, m."""
    local = rotate(place - pose[..., :2], -pose[..., 2])
    along = local[..., 0] - local[..., 0].clamp(0.0, wheels.ahead)
    return torch.hypot(along, local[..., 1]) - RADIUS


def crossing(count: int, seed: int = 1000) -> tuple[Tensor, Tensor, Tensor]:
    """Robots 5 m from their target, and people who cross their way where they would be then.

    Returns:
        Poses ``(N, 3)``, where the people are ``(N, 2)``, m, and their velocities, m/s.
    """
    generator = torch.Generator().manual_seed(seed)
    shares = torch.rand(4, count, generator=generator, dtype=torch.float64)
    still = torch.zeros_like(shares[0])

    poses = torch.stack((still, still, 2 * math.pi * shares[0]), dim=-1)
    time, speed = 4.0 + 5.0 * shares[1], 0.1 + 0.3 * shares[2]
    velocity = rotate(torch.stack((speed, still), dim=-1), 2 * math.pi * shares[3])
    meeting = torch.stack((0.5 * time, still), dim=-1)
    return poses, meeting - velocity * time.unsqueeze(-1), velocity


@pytest.mark.parametrize(
    "wheels",
    [
        pytest.param(DRIVE, id="differential drive"),
        pytest.param(CAR, id="bicycle", marks=pytest.mark.slow),
    ],
)
def test_a_robot_arrives_and_touches_nobody_who_crosses_its_way(wheels: Wheels) -> None:
    poses, people, velocity = crossing(64)
    is_clear = spine_gap(wheels, poses, people) > 0.5
    poses, people, velocity = poses[is_clear], people[is_clear], velocity[is_clear]

    policy, memory = among_people(wheels), None
    least = torch.full((len(poses),), torch.inf, dtype=torch.float64)
    nearest = least
    for step in range(900):
        readings = {
            "z_tar": noisy(range_and_bearing(poses, TARGET)[:, 1:], (BEARING_NOISE,), seed=step),
            "z_person": noisy(range_and_bearing(poses, people), NOISE, seed=10_000 + step),
        }
        action, memory = policy.predict(readings, memory)
        poses, people = rolled(poses, wheels.twist(action)), people + velocity * DT
        least = torch.minimum(least, spine_gap(wheels, poses, people))
        distance = (wheels.point_ahead(poses) - TARGET).norm(dim=-1)
        nearest = torch.minimum(nearest, distance)

    assert (least > 0).all()
    assert (nearest < 0.15).all()


@pytest.mark.parametrize("wheels", [DRIVE, None], ids=["on wheels", "in the world's axes"])
def test_it_learns_how_somebody_moves_while_the_robot_moves_as_well(wheels: Wheels | None) -> None:
    walking = person(wheels)
    estimator = walking.estimator()
    pose, place = torch.zeros(3).double(), torch.tensor([4.0, 1.0]).double()
    velocity, action = torch.tensor([-0.3, 0.2]).double(), torch.tensor([0.1, 0.2]).double()

    values: dict[str, Tensor] = {"dt": torch.tensor(DT, dtype=torch.float64)}
    for step in range(100):
        reading = noisy(range_and_bearing(pose, place), NOISE, seed=step)
        values["z_person"] = reading
        if step == 0:
            values |= estimator.initial(values)
        values["x_rob"] = action * DT if wheels is None else wheels.motion(action, DT)
        values |= estimator.update(values) if step else {}

        place = place + velocity * DT
        if wheels is None:
            pose = torch.cat((pose[:2] + action * DT, pose[2:]))
        else:
            pose = rolled(pose, wheels.twist(action))

    found = values["x_person"]
    assert isinstance(found, Tensor)
    expected = rotate(velocity, -pose[2])
    torch.testing.assert_close(found[2:], expected, atol=0.1, rtol=0.0)


def test_the_gap_to_come_is_that_to_the_way_ahead() -> None:
    """Somebody who walks away is as near as now, one who comes as near as he will be."""
    x = torch.tensor(
        [[3.0, 0.0, 0.5, 0.0], [3.0, 0.0, -0.5, 0.0], [3.0, 1.0, -2.0, 0.0], [0.1, 2.0, 0.0, 0.0]]
    )
    gap = GapToCome(radius=0.4, horizon=2.0, ahead=0.15)(x)
    expected = torch.tensor([3.0 - 0.15 - 0.4, 2.0 - 0.15 - 0.4, 1.0 - 0.4, 2.0 - 0.4])
    torch.testing.assert_close(gap, expected)

    now = GapToCome(radius=0.4, horizon=0.0, ahead=0.0)(x)
    torch.testing.assert_close(now, x[:, :2].norm(dim=-1) - 0.4)


def test_a_robot_without_wheels_keeps_off_as_well() -> None:
    """In the axes of the world, as a landmark is seen."""
    walking = person(None)
    model = WorldModel(
        sensors={"z_person": Sensor(2, "m and rad")},
        actuators={"a": Actuator(2, "m/s", limit=0.5)},
        estimators=[
            Deterministic("x_rob", lambda a, dt: a * dt, is_motion=True),
            walking.estimator(),
        ],
        goals=[Goal("avoid", walking.collision_likelihood(RADIUS, length=0.1, horizon=1.0))],
        dt=DT,
        dtype=torch.float64,
    )
    policy = Policy(model)
    action, _ = policy.predict({"z_person": torch.tensor([0.8, math.pi / 2]).double()})
    assert action[1] < -0.2

    readings = [{"z_person": 2.0 + 0.1 * normal(3, 2, seed=seed)} for seed in range(3)]
    assert_rows_stand_alone(policy, readings, rows=[1])


def test_paths_lead_from_the_obstacle_to_the_wheels() -> None:
    assert str(among_people(DRIVE).model.paths()).splitlines() == [
        "reach → p_tar → x_rob → a",
        "reach → P_tar → x_rob → a",
        "avoid → x_person → x_rob → a",
    ]
    assert "x_person" not in by_bearing(DRIVE).model.quantities


def test_numbers_are_checked() -> None:
    with pytest.raises(OptionError, match="range_noise=0"):
        MovingObstacle("x", "z", 0.0, 0.1, 0.1, DT)
    with pytest.raises(OptionError, match="motion_noise=-1"):
        MovingObstacle("x", "z", 0.1, 0.1, -1, DT)


def test_its_cost_is_kept_in_a_pickle() -> None:
    cost = person(None).collision_likelihood(RADIUS, length=0.1, horizon=1.0)
    assert pickle.loads(pickle.dumps(cost)).function == cost.function
