"""Colours and marks that the picture and the video share."""

from typing import Any

from matplotlib.colors import LinearSegmentedColormap

# Colours that colour-blind readers can tell apart (after Okabe and Ito, "Color Universal Design", 2008).
AGENT, TARGET, BELIEF, OBSTACLE, EXPLORING = "#0059a8", "#c4122f", "#e08a00", "#3c4048", "#a3569b"
ARROW = "#23454f"
HEIGHT = LinearSegmentedColormap.from_list("height", ["#fdfcf5", "#dfeae2", "#b5d2cb", "#86b3b1", "#5b8f96", "#3f6d7a"])
TINT, STRIP_TINT = 0.24, 0.16  # opacity of what says "exploring", in the world and over time

_POINT = {"markeredgecolor": "white", "linestyle": "none"}
TARGET_MARK: dict[str, Any] = _POINT | {
    "marker": "*",
    "markersize": 17,
    "markerfacecolor": TARGET,
    "markeredgewidth": 1.0,
}
MEAN_MARK: dict[str, Any] = _POINT | {
    "marker": "o",
    "markersize": 5.5,
    "markerfacecolor": BELIEF,
    "markeredgewidth": 0.9,
}
