"""Random bounds on an action, and how well one keeps them."""

import torch
from torch import Tensor

from _inputs.random_numbers import normal
from aicon_torch.safety import SafetyBounds


def random_bounds(*batch: int, rows: int = 5, size: int = 4, seed: int = 0) -> SafetyBounds:
    """Rows that rest keeps, and a box about rest."""
    low = -normal(*batch, size, seed=seed + 2).abs() - 0.1
    return SafetyBounds(
        slopes=normal(*batch, rows, size, seed=seed),
        bounds=-0.5 * normal(*batch, rows, seed=seed + 1).abs(),
        low=low,
        high=-low,
    )


def closing(action: Tensor, within: SafetyBounds) -> Tensor:
    """c·a − b of each row, at least 0 where it holds."""
    return (within.slopes * action.unsqueeze(-2)).sum(-1) - within.bounds


def random_metric(*batch: int, size: int = 4, seed: int = 20) -> Tensor:
    """Random symmetric positive definite matrices."""
    factor = normal(*batch, size, size, seed=seed)
    return factor @ factor.mT + 0.3 * torch.eye(size, dtype=torch.float64)
