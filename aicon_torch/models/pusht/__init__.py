"""The model "pusht": see :mod:`aicon_torch.models.pusht.graph`."""

from aicon_torch.models.pusht.graph import *  # noqa: F403
from aicon_torch.models.pusht.graph import PRESETS, Options, build
