"""What the rules of multi-task learning have in common when they resolve gradients that meet."""

import math
from dataclasses import dataclass
from typing import ClassVar

import torch
from torch import Tensor

from aicon_baselines.extras import require
from aicon_torch.resolution import GradientStack, Memory, Resolution


@dataclass(frozen=True)
class Aggregation(Resolution):
    """A rule J ↦ Jᵀw(J) from gradients as rows of a matrix J ``(n, d)`` to one gradient ``(d,)``.

    Such rules come from training with several losses. Here they stand where nullspace projection
    stands, and see the same stack. They remember nothing.

    All of them are scaled such that they give the sum of the gradients, not their mean, where that
    is what they give without a conflict: then a gain means the same as with
    :class:`~aicon_torch.resolution.Sum`.

    They compute with one matrix at a time, in Python, so a batch is a loop, and a policy with such
    a rule cannot be compiled: its ``compile()`` warns and runs uncompiled.

    Attributes:
        by_row: As in :class:`~aicon_torch.NullspaceProjection`, with the same default.
        modules: What the rule needs, of the extra "peers".

    Raises:
        ComparisonError: If a module is not installed; it says how to install it.
    """

    by_row: bool = True
    modules: ClassVar[tuple[str, ...]] = ()

    def __post_init__(self) -> None:
        """Check that what it needs is there."""
        require(type(self).__name__, "peers", *self.modules)

    def aggregate(self, matrix: Tensor) -> Tensor:
        """The gradient ``(d,)`` of a finite matrix ``(n, d)`` whose longest row has length one."""
        raise NotImplementedError

    def __call__(self, stack: GradientStack, memory: Memory) -> tuple[Tensor, Memory]:
        """The gradient of each row of the batch, ``(*B, d)``; nothing is remembered."""
        *batch, count, size = stack.gradients.shape
        matrices = stack.gradients.reshape(-1, count, size)

        resolved = torch.stack([self._resolve(matrix) for matrix in matrices])
        return resolved.reshape(*batch, size), memory

    def _resolve(self, matrix: Tensor) -> Tensor:
        """The rule at the scale of the longest gradient, since solvers have absolute tolerances.

        Where all are zero or one is not finite there is nothing to decide: it is their sum.
        """
        longest = float(torch.linalg.vector_norm(matrix, dim=-1).amax())
        if not 0.0 < longest < math.inf:
            return matrix.sum(-2)

        return longest * self.aggregate(matrix / longest)
