"""Evaluation: the same episodes for every policy, one row per episode, statistics and reports."""

from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.evaluation.predictor import Factory, Predictor

__all__ = ["ComparisonError", "Factory", "Predictor"]
