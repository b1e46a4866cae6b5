"""An arm, its postures, and what it is told."""

import copy
from typing import Any

import numpy as np
import torch
from torch import Tensor

from _inputs.random_numbers import normal
from aicon_torch.models.arm_push import PANDA
from aicon_torch.parts.chain import Chain
from aicon_torch.parts.end_effector import EndEffector, Pullback, ToolPose

HOME = torch.tensor([0.1, 0.3, -0.2, -2.2, 0.1, 2.5, 0.6], dtype=torch.float64)
"""Joint angles with the stick upright above the table, rad."""

LEVER = 0.2


def postures(count: int, seed: int = 0) -> Tensor:
    """Joint angles about :data:`HOME`, ``(count, 7)``."""
    return HOME + 0.2 * normal(count, 7, seed=seed)


def panda_chain() -> Chain:
    return copy.deepcopy(PANDA.chain)


def tool_pose() -> ToolPose:
    return ToolPose(PANDA.stick_length, LEVER)


def panda(pullback: Pullback = "natural", damping: float = 0.02) -> EndEffector:
    return EndEffector(panda_chain(), tool_pose(), pullback, damping)


def pose_observation(batch: tuple[int, ...] = (), **changes: Tensor) -> dict[str, Tensor]:
    """What the arm is told where the object's pose is observed."""
    readings = {
        "q": HOME,
        "target": torch.tensor([0.54, 0.05, 0.4], dtype=torch.float64),
        "object_pose": torch.tensor([0.5, -0.05, -0.8], dtype=torch.float64),
    }
    readings |= changes
    return {key: value.expand(*batch, value.shape[-1]) for key, value in readings.items()}


def camera_observation(**changes: Any) -> dict[str, Any]:
    """What the arm is told where it has a camera, which shows nothing but a grey table."""
    readings = {
        "rgb": np.full((120, 160, 3), 200, np.uint8),
        "depth": np.full((120, 160), 0.3, np.float32),
        "image_age": np.zeros(1),
        "q": HOME.numpy(),
        "dq": np.zeros(7),
        "ft": np.array([0.0, 0.0, -2.4525, 0.0, 0.0, 0.0]),
        "target": np.array([0.54, 0.0, 0.0]),
    }
    return readings | changes
