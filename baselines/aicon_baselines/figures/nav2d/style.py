"""Colours and marks that the picture and the film share."""

from typing import Any

from matplotlib.colors import LinearSegmentedColormap

from aicon_baselines.figures.style import EXPLORING, OBSTACLE, ROBOT, TARGET, TARGET_MARK

# Colours that colour-blind readers can tell apart (after Okabe and Ito, "Color Universal Design",
# 2008).
AGENT = ROBOT
BELIEF = "#e08a00"
ARROW, CERTAINTY = "#23454f", "#009268"
HEIGHT = LinearSegmentedColormap.from_list(
    "height", ["#fdfcf5", "#dfeae2", "#b5d2cb", "#86b3b1", "#5b8f96", "#3f6d7a"]
)

TINT = 0.24
"""Opacity of what says "exploring" in the world."""

MEAN_MARK: dict[str, Any] = {
    "marker": "o",
    "markersize": 5.5,
    "markerfacecolor": BELIEF,
    "markeredgecolor": "white",
    "markeredgewidth": 0.9,
    "linestyle": "none",
}

__all__ = [
    "AGENT",
    "ARROW",
    "BELIEF",
    "CERTAINTY",
    "EXPLORING",
    "HEIGHT",
    "MEAN_MARK",
    "OBSTACLE",
    "TARGET",
    "TARGET_MARK",
    "TINT",
]
