"""A graph whose paths double with every rung, to time a step against its edges.

u₀ = sin a, v₀ = cos a, and above them uᵢ = vᵢ = sin(uᵢ₋₁ + vᵢ₋₁): four more edges and twice the
paths with every rung.
"""

from typing import cast

import torch
from torch import Tensor

from aicon_torch import (
    Actuator,
    Deterministic,
    DirectDescent,
    Goal,
    Interconnection,
    Policy,
    Sensor,
    Sum,
    WorldModel,
)

READING = {"z": torch.zeros(1)}
"""What its only sensor, which nothing depends on, reads."""


def build(rungs: int) -> Policy:
    """Build a ladder of so many rungs, with a goal at its top and the action at its bottom."""
    estimators = [
        Deterministic("u0", Interconnection(torch.sin, ["a"])),
        Deterministic("v0", Interconnection(torch.cos, ["a"])),
    ]
    for rung in range(1, rungs):
        below = (f"u{rung - 1}", f"v{rung - 1}")
        for side in "uv":
            estimators.append(Deterministic(f"{side}{rung}", Interconnection(_blend, below)))

    top = [f"u{rungs - 1}", f"v{rungs - 1}"]
    model = WorldModel(
        sensors={"z": Sensor(1, "m")},
        actuators={"a": Actuator(2, "m/s", limit=1.0)},
        estimators=estimators,
        goals=[Goal("rest", Interconnection(_distance, top))],
    )
    return Policy(model, Sum(), DirectDescent(gain=1.0))


def _blend(u: Tensor, v: Tensor) -> Tensor:
    return torch.sin(u + v)


def _distance(u: Tensor, v: Tensor) -> Tensor:
    return cast(Tensor, torch.linalg.vector_norm(u - v, dim=-1))
