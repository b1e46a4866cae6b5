"""The model "picking": a gripper that picks blocks up and places them, among other things."""

from aicon_torch.models.picking.graph import (
    block_names,
    build_policy,
    free_hand,
    grasp_of,
    world_model,
)
from aicon_torch.models.picking.options import PRESETS, SIZE, Hand, Options, Surroundings

__all__ = [
    "PRESETS",
    "SIZE",
    "Hand",
    "Options",
    "Surroundings",
    "block_names",
    "build_policy",
    "free_hand",
    "grasp_of",
    "world_model",
]
