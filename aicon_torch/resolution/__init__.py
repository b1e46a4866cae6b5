"""Resolutions: what happens to the stack of gradients that meet at a quantity. One rule a file."""

from aicon_torch.resolution.base import GradientStack, Memory, RankedGradients, Resolution
from aicon_torch.resolution.escape import TrapEscape
from aicon_torch.resolution.exploration import Exploration
from aicon_torch.resolution.nullspace import NullspaceProjection
from aicon_torch.resolution.projectors import PROJECTORS
from aicon_torch.resolution.steepest import SteepestPath
from aicon_torch.resolution.sum import Sum

__all__ = [
    "PROJECTORS",
    "Exploration",
    "GradientStack",
    "Memory",
    "NullspaceProjection",
    "RankedGradients",
    "Resolution",
    "SteepestPath",
    "Sum",
    "TrapEscape",
]
