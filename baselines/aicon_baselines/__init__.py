"""Policies to compare and the comparison itself: the same episodes for every policy, one row per episode."""

from aicon_baselines.agents.registry import factory, make, names
from aicon_baselines.evaluation import ComparisonError, Predictor

__all__ = ["ComparisonError", "Predictor", "factory", "make", "names"]
