"""What tests of LeRobot's arms share: SO-101, its joints and its distance to a table."""

import functools
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from aicon_envs.reach import ReachEnv
from aicon_torch.parts import CapsuleSegments, Robot, SquaredHinge, Table

JOINTS = ("shoulder_pan", "shoulder_lift", "elbow_flex", "wrist_flex", "wrist_roll")


@functools.cache
def described() -> dict[str, Any]:
    """The description of the arm."""
    return ReachEnv("so101", "axis").description()


def to_action(degrees: Any) -> dict[str, float]:
    """The joints ``(5,)``, degrees, as LeRobot sends them."""
    return {f"{joint}.pos": float(x) for joint, x in zip(JOINTS, degrees, strict=True)}


def joints(observation: dict[str, Any]) -> NDArray[Any]:
    """The joints ``(5,)`` of an observation, rad."""
    return np.radians([observation[f"{joint}.pos"] for joint in JOINTS])


@functools.cache
def arm() -> Robot:
    """The arm, with its shape."""
    return Robot.from_urdf(described()["urdf"], tip=described()["tip"])


class AboveTable:
    """How far the links are above the table at 0 m, negative where they are below."""

    def __init__(self) -> None:
        shape = arm().shape
        assert shape is not None
        self._table = Table.under(arm(), 0.0, SquaredHinge(0.01, 1.0))
        self._segments = CapsuleSegments(arm().chain, shape.capsules)

    def __call__(self, posture: NDArray[Any]) -> Tensor:
        """The least distance ``(*B,)`` of postures ``(*B, 5)``, m."""
        return self._table.distances(self._segments(torch.as_tensor(posture))).amin(-1)
