"""Resolutions: what happens to the gradients that meet at a quantity."""

from aicon_torch.resolution.exploration import Escape, Exploration
from aicon_torch.resolution.nullspace import PROJECTORS, Memory, NullspaceProjection, Resolution, SteepestPath, Sum
from aicon_torch.resolution.stack import GradientStack, Ranked

__all__ = ["PROJECTORS", "Escape", "Exploration", "GradientStack", "Memory", "NullspaceProjection", "Ranked", "Resolution", "SteepestPath", "Sum"]
