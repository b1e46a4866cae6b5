"""The observation and action spaces of a robot that reaches."""

from typing import Any, Literal

from gymnasium import spaces

from aicon_envs.arm_push.spaces import LARGE, Observation, symmetric_box

Target = Literal["position", "axis", "pose"]


def observation_space(count: int, target: Target, balls: int) -> spaces.Space[Observation]:
    """Return the space of one observation of a robot with `count` joints."""
    boxes: dict[str, spaces.Space[Any]] = {
        "q": symmetric_box(LARGE, count),
        "dq": symmetric_box(LARGE, count),
        "target_position": symmetric_box(LARGE, 3),
    }

    if target != "position":
        boxes["target_orientation"] = symmetric_box(1.001, 3 if target == "axis" else 4)
    for number in range(1, balls + 1):
        boxes[f"ball_{number}"] = symmetric_box(LARGE, 3)

    observed: spaces.Space[Any] = spaces.Dict(boxes)  # Gymnasium types it as a space of spaces
    return observed
