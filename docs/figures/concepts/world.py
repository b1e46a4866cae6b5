"""The small world of the pictures: a robot in the plane, a target, and a wall in its way."""

from typing import NamedTuple

import numpy as np
import torch
from torch import Tensor

from aicon_baselines.evaluation.recording import FloatArray, to_array
from aicon_torch import (
    ActionLaw,
    Actuator,
    Affine,
    Deterministic,
    DirectDescent,
    Goal,
    KalmanFilter,
    Measurement,
    Policy,
    Resolution,
    Sensor,
    WorldModel,
)
from aicon_torch.inspection import QuantityTrace
from aicon_torch.resolution import Memory

DT, SPEED, REACH = 0.1, 1.0, 0.6
"""Time step in s, speed limit in m/s, and how far the wall is felt in m."""

MEETING = "x"
"""The quantity where the gradients meet: the robot's displacement in one step."""


class Wall(NamedTuple):
    """A straight wall between two points, m."""

    start: tuple[float, float]
    end: tuple[float, float]

    def nearest(self, place: Tensor) -> Tensor:
        """Its point nearest to a place (2,), m."""
        start, end = place.new_tensor(self.start), place.new_tensor(self.end)
        along = end - start
        share = ((place - start) @ along / (along @ along)).clamp(0.0, 1.0)
        return start + share * along


class Way(NamedTuple):
    """A robot's way of n steps: where it was (n + 1, 2), m, and what met in each step."""

    places: FloatArray
    meetings: list[QuantityTrace]

    @property
    def exploring(self) -> list[bool]:
        """Whether it explored in each step, (n,)."""
        return [bool(meeting.exploring) for meeting in self.meetings]


def move(a: Tensor, dt: float) -> Tensor:
    """How far the robot gets in one step, m."""
    return a * dt


def far(target: Tensor) -> Tensor:
    """Cost of the goal "reach": the distance, m."""
    distance: Tensor = torch.linalg.vector_norm(target, dim=-1)
    return distance


def near(wall: Tensor) -> Tensor:
    """Cost of the goal "avoid": it rises toward the wall, and is nothing from 0.6 m on."""
    return 0.6 * torch.relu(1.0 - torch.linalg.vector_norm(wall, dim=-1) / REACH) ** 2


def make_policy(resolution: Resolution | None = None, law: ActionLaw | None = None) -> Policy:
    """The policy: target and nearest point of the wall are seen, relative to the robot."""
    model = WorldModel(
        sensors={"z_target": Sensor(2, "m"), "z_wall": Sensor(2, "m")},
        actuators={"a": Actuator(2, "m/s", limit=SPEED)},
        estimators=[
            Deterministic(MEETING, move, is_motion=True),
            _seen("target"),
            _seen("wall"),
        ],
        goals=[Goal("reach", far), Goal("avoid", near)],
        dt=DT,
        dtype=torch.float64,
    )
    return Policy(model, resolution, law)


def readings(place: FloatArray, target: tuple[float, float], wall: Wall) -> dict[str, Tensor]:
    """What the robot sees at a place (2,), m."""
    robot = torch.as_tensor(place)
    return {
        "z_target": robot.new_tensor(target) - robot,
        "z_wall": wall.nearest(robot) - robot,
    }


def meeting_at(place: FloatArray, target: tuple[float, float], wall: Wall) -> QuantityTrace:
    """What meets at the robot's displacement at a place (2,), m."""
    policy = make_policy(law=DirectDescent())  # its gradients are those of this very place
    _, memory = policy.predict(readings(place, target, wall))
    return policy.trace(memory).quantities[MEETING]


def run(
    policy: Policy, start: tuple[float, float], target: tuple[float, float], wall: Wall, steps: int
) -> Way:
    """The robot's way from a start, until it arrives or has taken so many steps."""
    place = np.array(start)
    places = [place]
    meetings: list[QuantityTrace] = []
    memory: Memory | None = None

    while len(meetings) < steps and np.linalg.norm(place - target) > 0.03:
        action, memory = policy.predict(readings(place, target, wall), memory)
        meetings.append(policy.trace(memory).quantities[MEETING])
        place = place + DT * to_array(action)
        places.append(place)
    return Way(np.array(places), meetings)


def _seen(name: str) -> KalmanFilter:
    """Where something is, relative to the robot: it shifts back as the robot moves forward."""
    shift = Affine(**{name: 1.0, MEETING: -1.0})
    agreement = Affine(**{name: 1.0, f"z_{name}": -1.0})
    return KalmanFilter(
        name,
        f"P_{name}",
        predict=shift,
        noise=1e-4,
        initial=((1.0, 0.0), 9.0),
        correct=[Measurement(agreement, noise=1e-4, size=2)],
    )
