"""Colours that the picture and the film share."""

from aicon_baselines.figures.style import EXPLORING, GOAL, OBJECT, OUTLINE, ROBOT

# Colours that colour-blind readers can tell apart (after Okabe and Ito, "Color Universal Design",
# 2008).
PUSHER = ROBOT
USEFUL, DETRIMENTAL = "#009268", "#d55e00"
COST, INK, MOTION, BADGE, WALL = "#3c4048", "#1d2127", "#f4d35e", "#6d747e", "#eceef0"

GOAL_TINT, GROUND_TINT = 0.14, 0.08
"""Opacity of the goal's area, and of the ground that says "exploring"."""

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
    "USEFUL",
    "WALL",
]
