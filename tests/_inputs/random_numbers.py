"""The same random numbers in every run."""

import torch
from torch import Tensor

DTYPES = (torch.float32, torch.float64)
BATCHES: tuple[tuple[int, ...], ...] = ((), (1,), (3,), (2, 3))


def normal(*shape: int, seed: int = 0, dtype: torch.dtype = torch.float64) -> Tensor:
    """Standard normal numbers that depend on the seed alone; they are drawn in float64."""
    generator = torch.Generator().manual_seed(seed)
    return torch.randn(shape, generator=generator, dtype=torch.float64).to(dtype)


def random_covariance(*batch: int, size: int, seed: int = 0) -> Tensor:
    """Positive definite matrices ``(*B, size, size)``."""
    root = normal(*batch, size, size, seed=seed)
    return root @ root.mT + 0.1 * torch.eye(size, dtype=torch.float64)
