"""Small vector operations on stacks of gradients."""

import math
from collections.abc import Sequence

import torch
from torch import Tensor


def constants(numbers: Sequence[float | Tensor], like: Tensor) -> Tensor:
    """Numbers, of which some may learn, as a vector ``(n,)`` of the type of some values."""
    if any(isinstance(number, Tensor) for number in numbers):
        return torch.stack([number + like.new_zeros(()) for number in numbers])
    return like.new_tensor(numbers)


def unit(vectors: Tensor) -> Tensor:
    """The vectors ``(*B, d)`` at length one; those too short to be squared go to zero."""
    norms = torch.linalg.vector_norm(vectors, dim=-1, keepdim=True)
    directions: Tensor = vectors / norms.clamp(min=torch.finfo(vectors.dtype).tiny ** 0.5)
    return directions


def shorten(vectors: Tensor, longest: float | Tensor) -> Tensor:
    """The vectors ``(*B, d)``, those that are longer than a length ``(*B, 1)`` brought to it."""
    lengths = torch.linalg.vector_norm(vectors, dim=-1, keepdim=True)
    shortened: Tensor = vectors * (longest / lengths.clamp(min=longest))
    return shortened


def reject(vectors: Tensor, direction: Tensor) -> Tensor:
    """(I − vvᵀ) x: vectors ``(*B, d)`` without their component along a unit vector v."""
    rejected: Tensor = vectors - (vectors * direction).sum(-1, keepdim=True) * direction
    return rejected


def select(stack: Tensor, index: Tensor) -> Tensor:
    """The row ``(*B, d)`` of each stack ``(*B, n, d)`` that an index ``(*B, 1)`` names."""
    return stack.gather(-2, index.unsqueeze(-1).expand(*index.shape, stack.shape[-1])).squeeze(-2)


def wrap_angle(angle: Tensor) -> Tensor:
    """The same angle in [−π, π), rad."""
    return torch.remainder(angle + math.pi, 2 * math.pi) - math.pi
