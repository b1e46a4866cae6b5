"""The model "nav2d": a disc that steers to a target among obstacles."""

from aicon_torch.models.nav2d.graph import build, world_model
from aicon_torch.models.nav2d.options import PRESETS, Options

__all__ = ["PRESETS", "Options", "build", "world_model"]
