"""Two robots in one graph: they change places, and give way to each other.

What you learn: a graph has as many actuators as you like. A goal that reads both robots has a path
to each of them, so that both give way; no robot is the first, and no rule says who passes on which
side. The action is then one for each actuator, by name.

Two robots on wheels are watched by a camera above them, and each is to go to where the other one
stands.

    python examples/07_two_robots.py
"""

import math

import torch
from torch import Tensor

from aicon_torch import (
    Actuator,
    Deterministic,
    Estimator,
    Goal,
    Interconnection,
    Policy,
    Sensor,
    WorldModel,
)
from aicon_torch.export.codegen import has_compiler
from aicon_torch.parts import DifferentialDrive

DT = 0.05  # s
DRIVE = DifferentialDrive(track=0.3)
RADIUS = 0.35  # of a disc about the point ahead of a robot that holds all of it, m
PAIRS = 16  # of robots that change places, in a batch
ROBOTS = (1, 2)


def far_from(place: Tensor, target: Tensor) -> Tensor:
    """Cost of the goal "reach", m."""
    return (place - target).norm(dim=-1)


def likely_to_meet(ahead_1: Tensor, ahead_2: Tensor) -> Tensor:
    """Cost of the goal "apart": it grows steeply toward contact."""
    gap = (ahead_1 - ahead_2).norm(dim=-1) - 2 * RADIUS
    return torch.exp(-gap / 0.1)


def estimators_of(number: int) -> list[Estimator]:
    """How a robot moves, where it is, and where the point ahead of it is."""
    step, pose = f"x_{number}", f"pose_{number}"
    return [
        Deterministic(step, Interconnection(DRIVE.motion, [f"a_{number}", "dt"]), is_motion=True),
        DRIVE.pose_estimator(pose, f"z_{number}", (0.01, 0.01, 0.01), 0.0005, motion=step),
        Deterministic(f"ahead_{number}", Interconnection(DRIVE.point_ahead, [pose])),
    ]


def make_policy() -> Policy:
    """Both robots, each with its target, and what they keep between them."""
    sensors: dict[str, Sensor] = {}
    actuators: dict[str, Actuator] = {}
    estimators: list[Estimator] = []
    goals = [Goal("apart", likely_to_meet)]
    for number in ROBOTS:
        sensors[f"z_{number}"] = Sensor(3, "m, m and rad")
        sensors[f"target_{number}"] = Sensor(2, "m")
        actuators[f"a_{number}"] = Actuator(2, "m/s", limit=(0.5, 0.5))
        estimators.extend(estimators_of(number))
        distance = Interconnection(far_from, [f"ahead_{number}", f"target_{number}"])
        goals.append(Goal(f"reach {number}", distance))

    model = WorldModel(
        sensors=sensors,
        actuators=actuators,
        estimators=estimators,
        goals=goals,
        dt=DT,
        dtype=torch.float64,
    )
    return Policy(model)


def rolled(pose: Tensor, twist: Tensor) -> Tensor:
    """Where the wheels bring a robot in a step."""
    speed, turn = twist[:, 0] * DT, twist[:, 1] * DT
    direction = pose[:, 2] + turn / 2
    return pose + torch.stack((speed * direction.cos(), speed * direction.sin(), turn), dim=-1)


def opposite_poses(noise: torch.Generator) -> tuple[Tensor, Tensor]:
    """Robots 4 m apart, on either side of the origin, whose headings are anything."""
    angles = 2 * math.pi * torch.rand(3, PAIRS, generator=noise, dtype=torch.float64)
    place = 2.0 * torch.stack((angles[0].cos(), angles[0].sin()), dim=-1)
    first = torch.cat((place, angles[1].unsqueeze(-1)), dim=-1)
    second = torch.cat((-place, angles[2].unsqueeze(-1)), dim=-1)
    return first, second


def main() -> None:
    """Let them change places."""
    policy = make_policy()
    print(policy.model.paths())
    if has_compiler():
        policy = policy.compile()

    noise, memory = torch.Generator().manual_seed(0), None
    first, second = opposite_poses(noise)
    targets = {"target_1": second[:, :2].clone(), "target_2": first[:, :2].clone()}

    least_gap = math.inf
    for _ in range(round(40.0 / DT)):
        errors = 0.003 * torch.randn(2, PAIRS, 3, generator=noise, dtype=torch.float64)
        observation = {"z_1": first + errors[0], "z_2": second + errors[1], **targets}
        actions, memory = policy.predict(observation, memory)

        first = rolled(first, DRIVE.twist(actions["a_1"]))
        second = rolled(second, DRIVE.twist(actions["a_2"]))
        between = DRIVE.point_ahead(first) - DRIVE.point_ahead(second)
        least_gap = min(least_gap, float(between.norm(dim=-1).min()) - 2 * RADIUS)

    ends = torch.stack((DRIVE.point_ahead(first), DRIVE.point_ahead(second)))
    missing = (ends - torch.stack((*targets.values(),))).norm(dim=-1)
    print(f"\n{PAIRS} pairs: at least {100 * least_gap:.0f} cm between them,")
    print(f"and at most {100 * float(missing.max()):.0f} cm from their targets in the end")

    if least_gap < 0 or missing.max() > 0.05:
        raise SystemExit("They did not arrive, or met.")
    print("The robots have changed places, and did not touch.")


if __name__ == "__main__":
    main()
