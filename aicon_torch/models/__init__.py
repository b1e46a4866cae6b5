"""The paper's world models, built from the library's parts and imported by name."""

from aicon_torch.models.factory import MODELS, make_policy, presets
from aicon_torch.models.options import replace_options

__all__ = ["MODELS", "make_policy", "presets", "replace_options"]
