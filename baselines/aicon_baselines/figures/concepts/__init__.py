"""The idea in six pictures, each drawn from what a policy of a small world really computes."""

from aicon_baselines.figures.concepts.figure import PICTURES, make_figure

__all__ = ["PICTURES", "make_figure"]
