"""Colours that the picture and the video share; the pusher and the exploration have those of the navigation figure."""

from aicon_baselines.figures.nav2d.style import AGENT as PUSHER
from aicon_baselines.figures.nav2d.style import EXPLORING, STRIP_TINT

# Colours that colour-blind readers can tell apart (after Okabe and Ito, "Color Universal Design", 2008).
USEFUL, DETRIMENTAL = "#009268", "#d55e00"
OBJECT, OUTLINE, GOAL = "#c3c8d0", "#5c636e", "#5fb545"
COST, INK, MOTION, BADGE, WALL = "#3c4048", "#1d2127", "#f4d35e", "#6d747e", "#eceef0"
GOAL_TINT, GROUND_TINT = 0.14, 0.08  # opacity of the goal's area, and of the ground that says "exploring"

__all__ = [
    "BADGE",
    "COST",
    "DETRIMENTAL",
    "EXPLORING",
    "GOAL",
    "GOAL_TINT",
    "GROUND_TINT",
    "INK",
    "MOTION",
    "OBJECT",
    "OUTLINE",
    "PUSHER",
    "STRIP_TINT",
    "USEFUL",
    "WALL",
]
