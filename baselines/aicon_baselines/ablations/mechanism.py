"""Ablations of the mechanism that are the same in every task: options of the resolution."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

WEIGHTED_SUM: Mapping[str, Any] = MappingProxyType({"resolution.projector": "none"})
"""Gradients are added up, by the weights of the softmax."""

PLAIN_SUM: Mapping[str, Any] = MappingProxyType(
    {"resolution.projector": "none", "resolution.temperature": None}
)
"""Gradients are added up as they are; exploration stays."""

EARLIER_RULE: Mapping[str, Any] = MappingProxyType(
    {
        "resolution.temperature": 0.8,
        "resolution.by_row": True,
        "resolution.exploration.average_steps": 4.0,
    }
)
"""What was shipped before, with pushT's average of 0.4 s: flatter weights, summed by row."""
