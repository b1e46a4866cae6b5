"""The model "reach": any arm that takes its tip to a target, within its limits."""

from aicon_torch.models.reach.body import body_model, towards
from aicon_torch.models.reach.graph import build, world_model
from aicon_torch.models.reach.options import PRESETS, Options
from aicon_torch.parts.robot import Robot

__all__ = ["PRESETS", "Options", "Robot", "body_model", "build", "towards", "world_model"]
