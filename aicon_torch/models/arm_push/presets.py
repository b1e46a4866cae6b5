"""The arm's presets: ours and the baselines, as options that differ from the defaults."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from aicon_torch.resolution import SteepestPath, Sum

PRESETS: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "aicon": {},
        "steepest": {"resolution": SteepestPath()},
        "potential_field": {"resolution": Sum()},
    }
)
"""Options by preset: ours, the steepest path (Eq. 2), and plain backpropagation."""
