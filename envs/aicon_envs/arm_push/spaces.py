"""The observation and action spaces of the arm, and the checks at that border."""

from typing import Any, Literal

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from aicon_envs.arrays import FloatArray

ObsType = Literal["rgbd", "pose"]
Observation = dict[str, NDArray[Any]]
Action = NDArray[np.float32]

MAX_DEPTH = 10.0
"""Largest distance that the camera reports, m."""

LARGE = 1e3
"""A bound for what has none."""


def observation_space(
    joints: int, obs_type: ObsType, width: int, height: int
) -> spaces.Space[Observation]:
    """Return the space of one observation.

    Args:
        joints: Number of joints.
        obs_type: "rgbd" for the camera, "pose" for the true pose of the object instead.
        width: Width of images, px.
        height: Height of images, px.
    """
    boxes: dict[str, spaces.Space[Any]] = {
        "q": symmetric_box(LARGE, joints),
        "dq": symmetric_box(LARGE, joints),
        "ft": symmetric_box(1e5, 6),
        "target": symmetric_box(LARGE, 3),
    }

    if obs_type == "pose":
        boxes["object_pose"] = symmetric_box(LARGE, 3)
    else:
        boxes["rgb"] = spaces.Box(0, 255, (height, width, 3), np.uint8)
        boxes["depth"] = spaces.Box(0.0, MAX_DEPTH, (height, width), np.float32)
        boxes["image_age"] = spaces.Box(0.0, LARGE, (1,), np.float64)

    observed: spaces.Space[Any] = spaces.Dict(boxes)  # Gymnasium types it as a space of spaces
    return observed


def action_space(speed: FloatArray) -> spaces.Space[Action]:
    """Return the space of joint velocities up to some speeds ``(n,)``, rad/s or m/s."""
    largest = speed.astype(np.float32)
    return spaces.Box(-largest, largest, dtype=np.float32)


def symmetric_box(bound: float, length: int) -> spaces.Box:
    """Return a box from a bound below zero to the same above, ``(length,)``."""
    return spaces.Box(-bound, bound, (length,), np.float64)
