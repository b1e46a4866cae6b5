"""The model "panda_push": see :mod:`aicon_torch.models.panda_push.graph`."""

from aicon_torch.models.panda_push.graph import *  # noqa: F403
from aicon_torch.models.panda_push.graph import PRESETS, Options, build
