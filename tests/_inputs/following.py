"""A point that follows what it sees now and then, and readings of a pusher that passes by the T."""

from collections.abc import Callable

import torch
from torch import Tensor

from _inputs.random_numbers import normal
from aicon_torch import (
    EKF,
    Actuator,
    Affine,
    Deterministic,
    DirectDescent,
    Goal,
    Measurement,
    Policy,
    Sensor,
    Sum,
    WorldModel,
)

Readings = list[dict[str, Tensor]]


def moved(a: Tensor, dt: Tensor) -> Tensor:
    return a * dt


def distance(p: Tensor) -> Tensor:
    return (p * p).sum(-1).sqrt()


def bold_when_far(p: Tensor) -> Tensor:
    """No function of tensors alone: it looks at a value and branches."""
    is_far = p.detach()[..., 0] > 1.0
    if not is_far.any():
        return 2.0 * distance(p)
    return torch.where(is_far, distance(p), 2.0 * distance(p))


def follower(cost: Callable[..., Tensor] = distance, limit: float = 1.0) -> Policy:
    """A point that follows what it sees now and then."""
    seen = Measurement(Affine(p=1.0, z=-1.0), noise=0.01, size=2)

    model = WorldModel(
        sensors={"z": Sensor(2, "m", optional=True)},
        actuators={"a": Actuator(2, "m/s", limit=limit)},
        estimators=[
            Deterministic("x", moved, is_motion=True),
            EKF(
                "p",
                "P",
                predict=Affine(p=1.0, x=-1.0),
                noise=1e-4,
                initial=((1.0, 0.0), 1.0),
                correct=[seen],
            ),
        ],
        goals=[Goal("near", cost)],
        dt=0.1,
        dtype=torch.float64,
    )

    return Policy(model, Sum(), DirectDescent(gain=1.0))


def wandering(steps: int, batch: tuple[int, ...] = ()) -> Readings:
    """Where the point is seen; every third time it is not."""
    readings: Readings = []

    for step in range(steps):
        is_seen = batch != () or step % 3 != 2
        readings.append({"z": 2.0 + normal(*batch, 2, seed=step)} if is_seen else {})

    return readings


CORNERS = [(-60, -45), (60, -45), (60, -15), (-60, -15), (-15, -15), (15, -15), (15, 75), (-15, 75)]
"""The corners of the T in its own frame, px."""


def corners_at(pose: Tensor) -> Tensor:
    """The corners ``(*B, 16)`` of the T at (x, y, θ) ``(*B, 3)``, px and rad."""
    x, y = torch.tensor(CORNERS, dtype=torch.float64).unbind(-1)
    cos, sin = torch.cos(pose[..., 2:]), torch.sin(pose[..., 2:])

    turned = torch.stack((cos * x - sin * y, sin * x + cos * y), dim=-1)
    return (turned + pose[..., None, :2]).flatten(-2)


def passing(steps: int, batch: tuple[int, ...] = ()) -> Readings:
    """A pusher that passes by the T, whose corners are not always seen."""
    start = torch.tensor([256.0, 300.0, 0.3], dtype=torch.float64)
    spread = torch.tensor([1.0, 1.0, 0.01], dtype=torch.float64)
    readings: Readings = []

    for step in range(steps):
        pusher = torch.tensor([150.0 + 9.0 * step, 250.0 + 3.0 * step], dtype=torch.float64)
        pusher = pusher + normal(*batch, 2, seed=100 + step)

        corners = corners_at(start + spread * normal(*batch, 3, seed=step))
        if step % 4 == 3:
            corners = torch.full_like(corners, torch.nan)
        readings.append({"agent_pos": pusher, "environment_state": corners})

    return readings
