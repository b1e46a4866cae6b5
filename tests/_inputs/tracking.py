"""A small world model, which tests of the graph extend and break.

An agent moves, and a point is tracked.
"""

from typing import Any

import torch
from torch import Tensor

from aicon_torch import (
    EKF,
    Actuator,
    Deterministic,
    Estimator,
    Goal,
    Measurement,
    Sensor,
    WorldModel,
)


def move(a: Tensor, dt: float) -> Tensor:
    """The agent's displacement."""
    return a * dt


def approach(p: Tensor, x: Tensor) -> Tensor:
    """The point as seen from the agent, after it has moved."""
    return p - x


def match(p: Tensor, z: Tensor) -> Tensor:
    """Residual of a reading of the point."""
    return p - z


def near(p: Tensor) -> Tensor:
    """Cost of being far from the point."""
    return (p**2).sum(-1)


def tracked_point(**options: Any) -> EKF:
    """The filter of the point, with some of its options changed."""
    settings: dict[str, Any] = {
        "predict": approach,
        "noise": 0.1,
        "initial": ((1.0, 2.0), 1.0),
        "correct": [Measurement(match, 0.1, size=2)],
    }
    return EKF("p", "P", **(settings | options))


def tracking_model(*estimators: Estimator, goals: Any = None, **options: Any) -> WorldModel:
    """The model, with other estimators, goals or options."""
    settings: dict[str, Any] = {
        "sensors": {"z": Sensor(2, "m")},
        "actuators": {"a": Actuator(2, "m/s")},
        "estimators": estimators or [MOVE, TRACK],
        "goals": [Goal("near", near)] if goals is None else goals,
        "dt": 0.1,
        "dtype": torch.float64,
    }
    return WorldModel(**(settings | options))


# --- parts with rows


def corner(z: Tensor) -> Tensor:
    """Three rows that the reading places."""
    return torch.stack((z, 2 * z, 3 * z), dim=-2)


def of_corner(x: Tensor, corners: Tensor) -> Tensor:
    """Written for one row."""
    return x * corners


def far(y: Tensor) -> Tensor:
    """A cost on all rows."""
    return (y**2).sum((-1, -2))


MOVE = Deterministic("x", move)
TRACK = tracked_point()
CORNERS = Deterministic("corners", corner)


# --- a cycle


def rotate(p: Tensor, q: Tensor, x: Tensor) -> Tensor:
    """The prediction of one of two that read each other."""
    return p + torch.tanh(p * q) * x


def follow(q: Tensor, p: Tensor, x: Tensor) -> Tensor:
    """The prediction of the other one."""
    return q + torch.tanh(p * q) * x


def cyclic() -> WorldModel:
    """Two filters that read each other."""

    def product(p: Tensor, q: Tensor) -> Tensor:
        return (p * q).sum(-1)

    first = EKF("p", "P", predict=rotate, noise=0.1, initial=((0.1, 0.2), 1.0))
    second = EKF("q", "Q", predict=follow, noise=0.1, initial=((0.3, 0.5), 1.0))
    return tracking_model(first, second, MOVE, goals=[Goal("product", product)])
