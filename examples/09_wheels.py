"""Wheels: a robot that cannot move sideways finds its way, and keeps off who crosses it.

What you learn: a wheel does not move sideways, so goals are about a point ahead of the axle, which
goes where it likes; `DifferentialDrive` and `Bicycle` say what it does. The robot knows neither its
place nor its heading. It sees a beacon and a person in its own axes, and estimates how the person
walks.

A robot with two driven wheels and a small car go to the beacon, from every heading. Somebody
crosses their way just where they would be.

    python examples/09_wheels.py
"""

import math

import torch
from torch import Tensor

from aicon_torch import Actuator, Deterministic, Goal, Policy, Sensor, WorldModel
from aicon_torch.export.codegen import has_compiler
from aicon_torch.parts import Bicycle, DifferentialDrive, Landmark, MovingObstacle, Wheels, rotate

DT = 0.05  # s
RADIUS = 0.5  # of robot and person together, m
HEADINGS = 12

SIGHT_NOISE = 0.02  # m
BEARING_NOISE = 0.02  # rad
SLIP = 0.0003  # of the wheels in a step, m


def make_policy(wheels: Wheels, limit: tuple[float, float]) -> Policy:
    """To the beacon, past the person."""
    beacon = Landmark(
        "p_beacon",
        "z_beacon",
        noise=SIGHT_NOISE,
        motion_noise=SLIP,
        sees="position",
        wheels=wheels,
    )
    person = MovingObstacle(
        "x_person",
        "z_person",
        range_noise=SIGHT_NOISE,
        bearing_noise=BEARING_NOISE,
        motion_noise=SLIP,
        dt=DT,
        wheels=wheels,
    )

    model = WorldModel(
        sensors={"z_beacon": Sensor(2, "m"), "z_person": Sensor(2, "m and rad")},
        actuators={"a": Actuator(2, "m/s, or m/s and rad", limit=limit)},
        estimators=[
            Deterministic("x_rob", wheels.motion, is_motion=True),
            beacon.estimator(),
            person.estimator(),
        ],
        goals=[
            Goal("reach", beacon.expected_distance()),
            Goal("avoid", person.collision_likelihood(RADIUS, length=0.1, horizon=4.0)),
        ],
        dt=DT,
        dtype=torch.float64,
    )
    return Policy(model)


# The world, which the policy sees through its sensors only.


def seen(pose: Tensor, place: Tensor) -> Tensor:
    """A place in the axes of the robot, ``(N, 2)``, m."""
    return rotate(place - pose[:, :2], -pose[:, 2])


def rolled(pose: Tensor, twist: Tensor) -> Tensor:
    """Where the wheels bring a robot in a step."""
    speed, turn = twist[:, 0] * DT, twist[:, 1] * DT
    direction = pose[:, 2] + turn / 2
    return pose + torch.stack((speed * direction.cos(), speed * direction.sin(), turn), dim=-1)


def observe(
    pose: Tensor, beacon: Tensor, person: Tensor, noise: torch.Generator
) -> dict[str, Tensor]:
    """The beacon's position, and range and bearing of the person."""
    errors = torch.randn(4, len(pose), generator=noise, dtype=torch.float64)
    there = seen(pose, person)
    distance = there.norm(dim=-1) + SIGHT_NOISE * errors[0]
    bearing = torch.atan2(there[:, 1], there[:, 0]) + BEARING_NOISE * errors[1]
    return {
        "z_beacon": seen(pose, beacon) + SIGHT_NOISE * errors[2:].T,
        "z_person": torch.stack((distance, bearing), dim=-1),
    }


def run(wheels: Wheels, limit: tuple[float, float]) -> tuple[float, float]:
    """The least gap to the person, and the largest distance to the beacon in the end, m."""
    policy = make_policy(wheels, limit)
    if has_compiler():
        policy = policy.compile()
    print(policy.model.paths())

    headings = torch.linspace(-math.pi, math.pi, HEADINGS + 1, dtype=torch.float64)[1:]
    pose = torch.stack((0 * headings, 0 * headings, headings), dim=-1)
    beacon = torch.tensor([5.0, 0.0], dtype=torch.float64)
    person = torch.tensor([2.5, -1.6], dtype=torch.float64)  # and walks to the left
    velocity = torch.tensor([0.0, 0.3], dtype=torch.float64)

    noise, memory = torch.Generator().manual_seed(0), None
    least_gap = math.inf
    for _ in range(round(40.0 / DT)):
        action, memory = policy.predict(observe(pose, beacon, person, noise), memory)
        pose, person = rolled(pose, wheels.twist(action)), person + velocity * DT
        gap = (pose[:, :2] - person).norm(dim=-1).min() - RADIUS
        least_gap = min(least_gap, float(gap))

    return least_gap, float((wheels.point_ahead(pose) - beacon).norm(dim=-1).max())


def main() -> None:
    """Both robots, from every heading."""
    robots: dict[str, tuple[Wheels, tuple[float, float]]] = {
        "two driven wheels": (DifferentialDrive(track=0.3), (0.5, 0.5)),
        "a small car": (Bicycle(wheelbase=0.3), (0.5, 0.6)),
    }
    for name, (wheels, limit) in robots.items():
        least_gap, distance = run(wheels, limit)
        print(f"{name}, {HEADINGS} headings: at least {100 * least_gap:.0f} cm from the person,")
        print(f"and at most {100 * distance:.0f} cm from the beacon in the end\n")
        if least_gap < 0 or distance > 0.05:
            raise SystemExit("It did not arrive, or touched somebody.")

    print("Both robots arrive from every heading, and touch nobody.")


if __name__ == "__main__":
    main()
