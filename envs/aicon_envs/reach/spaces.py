"""The observation and action spaces of a robot that reaches."""

import math
from typing import Any, Literal

from gymnasium import spaces

from aicon_envs.arm_push.spaces import Observation, symmetric_box

Target = Literal["position", "axis", "pose"]

_LARGE = 1e3
"""A bound for what has none."""


def observation_space(count: int, target: Target, balls: int) -> spaces.Space[Observation]:
    """Return the space of one observation of a robot with `count` joints."""
    boxes: dict[str, spaces.Space[Any]] = {
        "q": symmetric_box(4 * math.pi, count),
        "dq": symmetric_box(_LARGE, count),
        "target_position": symmetric_box(_LARGE, 3),
    }

    if target != "position":
        boxes["target_orientation"] = symmetric_box(1.001, 3 if target == "axis" else 4)
    for number in range(1, balls + 1):
        boxes[f"ball_{number}"] = symmetric_box(_LARGE, 3)

    observed: spaces.Space[Any] = spaces.Dict(boxes)  # Gymnasium types it as a space of spaces
    return observed
