"""The policies that can be compared, by task and name."""

from aicon_baselines.agents.registry import (
    ablations,
    compiled,
    factory,
    make,
    names,
    opponents,
)

__all__ = ["ablations", "compiled", "factory", "make", "names", "opponents"]
