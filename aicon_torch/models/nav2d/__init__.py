"""The model "nav2d": a disc that steers to a target among obstacles."""

from aicon_torch.models.nav2d.graph import build, world_model
from aicon_torch.models.nav2d.options import Options
from aicon_torch.models.nav2d.presets import PRESETS

__all__ = ["PRESETS", "Options", "build", "world_model"]
