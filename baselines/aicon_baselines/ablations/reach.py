"""Ablations of the policy that reaches."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

ABLATIONS: Mapping[str, Mapping[str, Any]] = MappingProxyType({})
"""Options by name, on top of the preset ``"aicon"``."""
