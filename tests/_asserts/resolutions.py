"""The projection's selection in plain loops, and orthogonality."""

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor


def selection(gradients: Tensor, held: Tensor, margin: float) -> tuple[Tensor, list[int]]:
    """Eq. 7-8 for one stack ``(n, d)``, in plain loops.

    The projected gradient of each rank, and its candidate.

    Each candidate is projected onto the complement of the span of all original gradients before it,
    by least squares.
    """
    stack = gradients.double().numpy()
    chosen: list[int] = []
    selected: list[NDArray[np.float64]] = []

    for rank in range(min(stack.shape)):
        remaining = _outside_span(stack, chosen)

        strengths = np.linalg.norm(remaining, axis=-1)
        if held[rank] >= 0:
            strengths[int(held[rank])] *= 1.0 + margin

        chosen.append(int(strengths.argmax()))
        selected.append(remaining[chosen[-1]])

    return torch.as_tensor(np.array(selected)), chosen


def _outside_span(stack: NDArray[np.float64], chosen: list[int]) -> NDArray[np.float64]:
    """What is left of the gradients without the span of those that were chosen."""
    remaining = stack.copy()
    if not chosen:
        return remaining

    basis = stack[chosen].T
    coefficients = np.linalg.lstsq(basis, stack.T, rcond=1e-12)[0]
    remaining -= (basis @ coefficients).T
    remaining[chosen] = 0.0
    return remaining


def assert_orthogonal(vectors: Tensor, scale: Tensor) -> None:
    """The products of different rows ``(*B, k, d)`` are nothing but rounding, on some scale ``(*B,
    k, k)``.
    """
    products = vectors @ vectors.mT
    squares = torch.diag_embed(products.diagonal(dim1=-2, dim2=-1))

    assert ((products - squares).abs() <= 1e-10 * scale).all()
