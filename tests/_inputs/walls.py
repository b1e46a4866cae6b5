"""A point that moves in the plane, a target, and what it must not come near."""

from collections.abc import Callable, Sequence
from typing import Any

import torch
from torch import Tensor, nn

from aicon_torch import (
    Actuator,
    Affine,
    Deterministic,
    DirectDescent,
    Goal,
    KalmanFilter,
    Measurement,
    Policy,
    Sensor,
    WorldModel,
)
from aicon_torch.dampers import VelocityDampers

DT = 0.05


class Wall(nn.Module):
    """Nothing is left of a gap at x = 1."""

    def forward(self, x: Tensor) -> Tensor:
        return (-self.gaps(x)[..., 0]).clamp(min=0.0)

    def gaps(self, x: Tensor) -> Tensor:
        return 1.0 - x[..., :1]


def far_from_target(x: Tensor, z_target: Tensor) -> Tensor:
    return (x - z_target).norm(dim=-1)


def left_of_wall(x: Tensor) -> Tensor:
    """The same wall as a cost alone."""
    return x[..., 0]


def point_policy(
    goals: Sequence[Goal] = (),
    speed: float = 1.0,
    dt: float = DT,
    dampers: VelocityDampers | None = None,
    constraints: Sequence[Callable[..., Tensor]] = (),
    **parts: Any,
) -> Policy:
    """A policy of a point that goes straight to a target, and whatever keeps it from it."""
    agreement = Affine(x=1.0, z=-1.0)
    position = KalmanFilter(
        "x",
        "P",
        predict=Affine(x=1.0, a=dt),
        noise=1e-4,
        initial=((0.0, 0.0), 1.0),
        correct=[Measurement(agreement, 1e-8, size=2)],
    )
    model = WorldModel(
        sensors={"z": Sensor(2, "m"), "z_target": Sensor(2, "m"), **parts.pop("sensors", {})},
        actuators={
            "a": Actuator(
                2,
                "m/s",
                limit=(speed, speed),
                keeps_direction=True,
                constraints=constraints,
                dampers=dampers or VelocityDampers(),
            )
        },
        estimators=[position, *parts.pop("estimators", ())],
        goals=[Goal("reach", far_from_target), *goals],
        dt=dt,
        dtype=torch.float64,
    )
    return Policy(model, law=DirectDescent(smoothing=0.0), **parts)


def drive(
    policy: Policy, start: Tensor, target: Tensor, steps: int, **more: Tensor
) -> tuple[Tensor, dict[str, Tensor]]:
    """The way of the point, ``(steps + 1, *B, 2)``, and the last memory."""
    way, memory = [start], None
    for _ in range(steps):
        observation = {"z": way[-1], "z_target": target, **more}
        action, memory = policy.predict(observation, memory)
        way.append(way[-1] + policy.model.dt * action)

    assert memory is not None
    return torch.stack(way), memory


def wall(**options: Any) -> Goal:
    return Goal("wall", Wall(), safety=True, **options)


def place(*coordinates: float) -> Tensor:
    return torch.tensor(coordinates, dtype=torch.float64)


__all__ = ["Deterministic", "Wall", "drive", "left_of_wall", "place", "point_policy", "wall"]
