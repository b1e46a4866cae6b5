"""What is where in the world of each task, for figures, films and the live view alike."""

from aicon_baselines.worlds.shape import Shape, arrow, believed, disc, star
from aicon_baselines.worlds.surroundings import navigation, pushing, surroundings

__all__ = ["Shape", "arrow", "believed", "disc", "navigation", "pushing", "star", "surroundings"]
