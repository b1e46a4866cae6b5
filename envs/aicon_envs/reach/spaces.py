"""The observation and action spaces of a robot that reaches."""

import math
from typing import Any, Literal

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

Target = Literal["position", "axis", "pose"]
Observation = dict[str, NDArray[Any]]
Action = NDArray[np.float32]

_LARGE = 1e3
"""A bound for what has none."""


def observation_space(count: int, target: Target, balls: int) -> spaces.Space[Observation]:
    """Return the space of one observation of a robot with `count` joints."""
    boxes: dict[str, spaces.Space[Any]] = {
        "q": _symmetric_box(4 * math.pi, count),
        "dq": _symmetric_box(_LARGE, count),
        "target_position": _symmetric_box(_LARGE, 3),
    }

    if target != "position":
        boxes["target_orientation"] = _symmetric_box(1.001, 3 if target == "axis" else 4)
    for number in range(1, balls + 1):
        boxes[f"ball_{number}"] = _symmetric_box(_LARGE, 3)

    observed: spaces.Space[Any] = spaces.Dict(boxes)  # Gymnasium types it as a space of spaces
    return observed


def action_space(speed: NDArray[np.float64]) -> spaces.Space[Action]:
    """Return the space of joint velocities up to a speed ``(n,)``, rad/s or m/s."""
    bound = speed.astype(np.float32)
    box: spaces.Space[Any] = spaces.Box(-bound, bound, dtype=np.float32)  # forgets its dtype
    return box


def _symmetric_box(bound: float, length: int) -> spaces.Box:
    return spaces.Box(-bound, bound, (length,), np.float64)
