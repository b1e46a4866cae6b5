"""The potential's colours, and the marks that the picture and the film share."""

from typing import Any

from matplotlib.colors import LinearSegmentedColormap

from aicon_baselines.palette import BELIEF

ARROW = "#23454f"
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
