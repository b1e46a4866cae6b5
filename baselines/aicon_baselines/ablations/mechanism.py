"""Ablations of the mechanism that are the same in every task."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from aicon_baselines.named import Later

WEIGHTED_SUM: Mapping[str, Any] = MappingProxyType({"resolution.projector": "none"})
"""Gradients are added up, by the weights of the softmax."""

PLAIN_SUM: Mapping[str, Any] = MappingProxyType(
    {"resolution.projector": "none", "resolution.temperature": None}
)
"""Gradients are added up as they are; exploration stays."""

ONE_GRADIENT: Mapping[str, Any] = MappingProxyType({"law.iterations": 1, "law.step": 1.0})
"""One gradient a step, taken where the model foresees that the step begins."""

WITHOUT_FORESIGHT: Mapping[str, Any] = MappingProxyType(
    {"law": Later("aicon_torch.control:DirectDescent")}
)
"""One gradient a step, taken where the robot is."""

TEXTS_EXPLORATION: Mapping[str, Any] = MappingProxyType(
    {"resolution.exploration": Later("aicon_torch.resolution:Exploration.as_in_paper")}
)

TEXT_SUM: Mapping[str, Any] = MappingProxyType(
    {**PLAIN_SUM, **TEXTS_EXPLORATION, **WITHOUT_FORESIGHT}
)
"""The text by one gradient a step, but that gradients are added up."""
