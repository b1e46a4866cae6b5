"""Ablations of the arm."""

from aicon_baselines.ablations.panda_push import ABLATIONS

__all__ = ["ABLATIONS"]
