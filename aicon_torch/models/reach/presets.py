"""Presets of reaching: ours and the baselines, as options that differ from the defaults."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from aicon_torch.resolution import SteepestPath, Sum

PRESETS: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "aicon": {},
        "without_escape": {"dampers.escape": None},
        "steepest": {"safety": False, "resolution": SteepestPath()},
        "potential_field": {"safety": False, "resolution": Sum()},
    }
)
"""Options by preset: ours, ours without the escape, and the baselines, for which joint limits and
self-collision are goals like any other."""
