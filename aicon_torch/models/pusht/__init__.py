"""The model "pusht": a disc that pushes an object to a pose."""

from aicon_torch.models.pusht.benchmark import PIXEL
from aicon_torch.models.pusht.graph import build, world_model
from aicon_torch.models.pusht.options import PRESETS, Options
from aicon_torch.models.pusht.pushed_object import rigid_object

__all__ = ["PIXEL", "PRESETS", "Options", "build", "rigid_object", "world_model"]
