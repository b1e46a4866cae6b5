"""The steepest path: the rule of the original AICON."""

from dataclasses import dataclass
from typing import ClassVar

import torch
from torch import Tensor

from aicon_torch.resolution.base import GradientStack, Memory, Resolution
from aicon_torch.vectors import select


@dataclass(frozen=True)
class SteepestPath(Resolution):
    """∇ of p* = argmax ‖∇ᵖ‖ over complete paths (Eq. 2), the rule of the original AICON."""

    merges: ClassVar[bool] = False

    def initial(self, count: int, size: int) -> Memory:
        """No path was taken yet (−1)."""
        return {"rank": torch.full((1,), -1)}

    def __call__(self, stack: GradientStack, memory: Memory) -> tuple[Tensor, Memory]:
        """The longest of the gradients, ``(*B, d)``, and its index as the one of rank 0."""
        magnitudes = torch.linalg.vector_norm(stack.gradients, dim=-1)
        steepest = magnitudes.argmax(-1, keepdim=True)

        return select(stack.gradients, steepest), {"rank": steepest}
