"""Policies to compare and the comparison itself: the same episodes for every policy, one row per episode."""

from aicon_baselines.errors import ComparisonError
from aicon_baselines.policies import factory, make, names
from aicon_baselines.protocol import Predictor

__all__ = ["ComparisonError", "Predictor", "factory", "make", "names"]
