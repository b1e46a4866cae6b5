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
