"""Figures and films of real rollouts: everything drawn happened, or is what the policy knew."""

from aicon_baselines.figures.rendering import VIDEO_FORMATS
from aicon_baselines.figures.summary import FigureSummary

__all__ = ["VIDEO_FORMATS", "FigureSummary"]
