"""Marks and tints that the figures of several tasks share."""

from typing import Any

import numpy as np
from matplotlib.colors import to_rgb
from numpy.typing import ArrayLike

from aicon_baselines.evaluation.recording import FloatArray
from aicon_baselines.palette import TARGET

TARGET_MARK: dict[str, Any] = {
    "marker": "*",
    "markersize": 17,
    "markerfacecolor": TARGET,
    "markeredgecolor": "white",
    "markeredgewidth": 1.0,
    "linestyle": "none",
}

TIMELINE_TINT = 0.16
"""Opacity of what says "exploring" over time."""


def blend(color: str, opacity: float, ground: ArrayLike = (1.0, 1.0, 1.0)) -> FloatArray:
    """The opaque colour that a colour of some opacity has on a ground, by default on white.

    Args:
        color: The colour.
        opacity: From 0 to 1.
        ground: Red, green and blue from 0 to 1, (..., 3).

    Returns:
        Red, green and blue, (..., 3).
    """
    return opacity * np.array(to_rgb(color)) + (1.0 - opacity) * np.asarray(ground)
