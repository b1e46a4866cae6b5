"""What is where in the world of each task, for figures, films and the live view alike."""

from aicon_baselines.worlds.shape import Shape, believed, disc, star
from aicon_baselines.worlds.surroundings import (
    ARRIVAL,
    GOAL_TINT,
    navigation,
    pushing,
    surroundings,
)

__all__ = [
    "ARRIVAL",
    "GOAL_TINT",
    "Shape",
    "believed",
    "disc",
    "navigation",
    "pushing",
    "star",
    "surroundings",
]
