"""The model "nav2d": see :mod:`aicon_torch.models.nav2d.graph`."""

from aicon_torch.models.nav2d.graph import *  # noqa: F403
from aicon_torch.models.nav2d.graph import PRESETS, Options, build
