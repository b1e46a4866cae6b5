"""A point among round pillars, and somebody who proposes to go straight on."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import torch
from torch import Tensor

from aicon_torch import Actuator, Affine, Goal, KalmanFilter, Measurement, Sensor, WorldModel
from aicon_torch.dampers import VelocityDampers

DT, RADIUS, TARGET = 0.05, 0.5, (3.0, 0.0)
PILLARS = {"pillar": (1.5, 0.0)}
TRAP = {f"post_{i}": (1.5 + 0.25 * abs(i), 0.6 * i) for i in (-1, 0, 1)} | {
    f"end_{i}": (1.0, 0.9 * i) for i in (-1, 1)
}


def located() -> KalmanFilter:
    """Where the point is: as it is read, and moved by its velocity."""
    agreement = Measurement(Affine(x=1.0, position=-1.0), 1e-12, size=2)
    moved, start = Affine(x=1.0, v="dt"), ((0.0, 0.0), 1.0)
    return KalmanFilter("x", "P", predict=moved, noise=1e-6, initial=start, correct=[agreement])


def world(pillars: Mapping[str, tuple[float, float]] = PILLARS, **actuator: Any) -> WorldModel:
    """A point that knows where it is, among round pillars."""

    def gap_to(centre: tuple[float, float]) -> Callable[[Tensor], Tensor]:
        return lambda x: RADIUS - (x - x.new_tensor(centre)).norm(dim=-1)

    dampers = VelocityDampers(braking=0.2)
    return WorldModel(
        sensors={"position": Sensor(2, "m")},
        actuators={"v": Actuator(2, "m/s", limit=1.0, **{"dampers": dampers, **actuator})},
        estimators=[located()],
        goals=[Goal(name, gap_to(centre), safety=True) for name, centre in pillars.items()],
        dt=DT,
        dtype=torch.float64,
    )


def straight(observation: Mapping[str, Any]) -> Any:
    """Toward the target, whatever is in the way."""
    way = np.asarray(TARGET) - observation["position"]
    return way / np.maximum(np.linalg.norm(way, axis=-1, keepdims=True), 0.3)
