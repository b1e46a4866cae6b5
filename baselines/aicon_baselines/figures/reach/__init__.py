"""The figure of arms that reach: moments of an episode of each, and how near it came to what."""

from aicon_baselines.figures.reach.figure import (
    ReachRollout,
    draw_picture,
    make_figure,
    record_reach,
)

__all__ = ["ReachRollout", "draw_picture", "make_figure", "record_reach"]
