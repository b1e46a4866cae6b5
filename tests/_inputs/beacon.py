"""A nonlinear filter: an agent drives, and a beacon is seen under an angle."""

from typing import Any

import torch
from torch import Tensor

from _inputs.random_numbers import normal
from aicon_torch import EKF, Measurement


def drive(x: Tensor, a: Tensor) -> Tensor:
    """The beacon's position after driving into a direction (rad) at a speed."""
    heading, speed = a.unbind(-1)
    return x + 0.1 * torch.stack((torch.cos(heading) * speed, torch.sin(heading) * speed), dim=-1)


def bearing(x: Tensor, z: Tensor) -> Tensor:
    """Residual of the angle under which the beacon is seen."""
    return torch.atan2(x[..., 1:], x[..., :1]) - z


def beacon(**options: Any) -> EKF:
    """The beacon's filter, with some of its options changed."""
    settings: dict[str, Any] = {
        "noise": 0.01,
        "initial": ((2.0, 1.0), 0.5),
        "correct": [Measurement(bearing, 0.04)],
    }
    return EKF("x", "P", predict=drive, **(settings | options))


def beacon_values(batch: tuple[int, ...] = (), seed: int = 0, **known: Tensor) -> dict[str, Tensor]:
    """Values to update it at."""
    root = normal(*batch, 2, 2, seed=seed)
    values = {
        "x": torch.tensor([2.0, 1.0], dtype=torch.float64) + 0.3 * normal(*batch, 2, seed=seed + 1),
        "P": root @ root.mT + 0.2 * torch.eye(2, dtype=torch.float64),
        "a": normal(*batch, 2, seed=seed + 2),
        "z": 0.5 + 0.1 * normal(*batch, 1, seed=seed + 3),
    }
    return values | known
