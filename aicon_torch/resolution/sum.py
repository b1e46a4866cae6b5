"""The sum of the gradients: a potential field."""

from dataclasses import dataclass

from torch import Tensor

from aicon_torch.resolution.base import GradientStack, Memory, Resolution


@dataclass(frozen=True)
class Sum(Resolution):
    """Σᵢ ∇ᵢ: plain backpropagation, whose descent is that of a potential field."""

    def __call__(self, stack: GradientStack, memory: Memory) -> tuple[Tensor, Memory]:
        """The sum of the gradients ``(*B, d)``; nothing is remembered."""
        return stack.gradients.sum(-2), memory
