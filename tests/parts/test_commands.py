"""Robots that are commanded forces or displacements, steered by velocities."""

from typing import NamedTuple

import pytest
import torch
from _inputs import quick
from torch import Tensor

from aicon_torch import Actuator, Deterministic, Goal, OptionError, Policy, Sensor, WorldModel
from aicon_torch.control import Foresight
from aicon_torch.parts import DisplacementCommand, ForceServo, Landmark
from aicon_torch.resolution import NullspaceProjection

DT = 0.05


def at(*numbers: float) -> Tensor:
    return torch.tensor(numbers, dtype=torch.float64)


class Mass(NamedTuple):
    """A mass in the plane: where it is and how fast, m and m/s."""

    place: Tensor
    velocity: Tensor

    def pushed(self, force: Tensor, mass: float) -> "Mass":
        """After a step under a force, N, by a hundred short steps of its equation of motion."""
        place, velocity = self
        for _ in range(100):
            velocity = velocity + force / mass * (DT / 100)
            place = place + velocity * (DT / 100)
        return Mass(place, velocity)


def displacement(a: Tensor, dt: float) -> Tensor:
    return a * dt


def velocity(z_velocity: Tensor) -> Tensor:
    return z_velocity


def test_the_force_brings_the_mass_to_the_wish_with_the_time_constant() -> None:
    servo = ForceServo(mass=2.0, time=0.2, largest=1e6)
    nominal, velocity = at(0.4, -0.2), at(-0.1, 0.3)

    acceleration = servo(nominal, velocity) / 2.0
    torch.testing.assert_close(acceleration, (nominal - velocity) / 0.2)


def test_the_force_is_no_longer_than_the_largest_and_keeps_its_direction() -> None:
    servo = ForceServo(mass=2.0, time=0.1, largest=5.0)
    force = servo(at(3.0, 4.0), at(0.0, 0.0))
    torch.testing.assert_close(force, at(3.0, 4.0))
    assert servo(at(0.03, 0.04), at(0.0, 0.0)).norm() == pytest.approx(1.0)


def test_the_displacement_is_that_of_the_mass() -> None:
    servo = ForceServo(mass=2.0, time=0.2, largest=1e6)
    nominal, start = at(0.4, -0.2), Mass(at(0.0, 0.0), at(-0.1, 0.3))

    moved = start.pushed(servo(nominal, start.velocity), 2.0).place
    foreseen = servo.displacement(nominal, start.velocity, DT)
    torch.testing.assert_close(foreseen, moved, atol=2e-4, rtol=0.0)


def test_a_force_at_its_largest_moves_the_mass_no_farther() -> None:
    servo = ForceServo(mass=2.0, time=0.1, largest=4.0)
    at_rest = torch.zeros(1, dtype=torch.float64)
    foreseen = servo.displacement(at_rest + 2.0, at_rest, 0.1 + at_rest)
    torch.testing.assert_close(foreseen, at_rest + 4.0 / 2.0 * 0.1**2 / 2)


def test_a_mass_that_is_commanded_forces_comes_to_its_target_and_rests_there() -> None:
    servo = ForceServo(mass=2.0, time=0.1, largest=40.0)
    target = Landmark("p_tar", "z_tar", noise=0.002, motion_noise=1e-3, sees="position")
    sensors = {"z_tar": Sensor(2, "m", key="target"), "z_velocity": Sensor(2, "m/s", key="v")}
    model = WorldModel(
        sensors=sensors,
        actuators={"a": Actuator(2, "m/s", limit=0.5, command=servo)},
        estimators=[
            Deterministic("v_robot", velocity),
            Deterministic("x_rob", servo.displacement, is_motion=True),
            target.estimator(),
        ],
        goals=[Goal("reach", target.expected_distance())],
        dt=DT,
    )
    policy = quick(Policy(model, NullspaceProjection(), Foresight()))

    place, mass, memory = at(1.0, -0.6), Mass(at(0.0, 0.0), at(0.0, 0.0)), None
    for _ in range(100):
        reading = {"target": place - mass.place, "v": mass.velocity}
        force, memory = policy.predict(reading, memory)
        mass = mass.pushed(torch.as_tensor(force), 2.0)

    assert (place - mass.place).norm() < 0.02
    assert mass.velocity.norm() < 0.05


def test_a_robot_that_is_commanded_displacements_comes_to_its_target() -> None:
    target = Landmark("p_tar", "z_tar", noise=0.002, motion_noise=1e-3, sees="position")
    command = DisplacementCommand(unit=0.05)
    model = WorldModel(
        sensors={"z_tar": Sensor(2, "m", key="target")},
        actuators={"a": Actuator(2, "m/s", limit=2.0, command=command)},
        estimators=[Deterministic("x_rob", displacement, is_motion=True), target.estimator()],
        goals=[Goal("reach", target.expected_distance())],
        dt=DT,
    )
    policy = quick(Policy(model, NullspaceProjection(), Foresight()))

    left, memory = at(0.7, -0.4), None
    for _ in range(60):
        action, memory = policy.predict({"target": left}, memory)
        assert abs(action).max() <= 1.0
        left = left - 0.05 * torch.as_tensor(action)
    assert left.norm() < 0.02


def test_displacements_are_in_the_units_of_the_robot_and_bounded() -> None:
    command = DisplacementCommand(unit=0.05)
    torch.testing.assert_close(command(at(0.5, -3.0), DT), at(0.5, -1.0))


@pytest.mark.parametrize("wrong", [{"mass": 0.0}, {"time": -1.0}, {"largest": 0.0}])
def test_numbers_that_cannot_be_are_errors(wrong: dict[str, float]) -> None:
    (name,) = wrong
    with pytest.raises(OptionError, match=name):
        ForceServo(**{"mass": 1.0, "time": 0.1, "largest": 1.0} | wrong)
    with pytest.raises(OptionError, match="unit"):
        DisplacementCommand(unit=0.0)
