"""Kalman corrections against the textbook's formulas."""

import pytest
import torch
from _inputs import BATCHES, DTYPES, normal, random_covariance

from aicon_torch.estimation import Correction


@pytest.mark.parametrize("batch", BATCHES, ids=str)
@pytest.mark.parametrize("rows", [1, 2, 3])
def test_a_correction_is_the_textbook_s(batch: tuple[int, ...], rows: int) -> None:
    covariance = random_covariance(*batch, size=3)
    noise = random_covariance(*batch, size=rows, seed=1)
    residual, jacobian = normal(*batch, rows, seed=2), normal(*batch, rows, 3, seed=3)
    correction = Correction.by(covariance, jacobian, noise)

    spread = jacobian @ covariance @ jacobian.mT + noise
    gain = covariance @ jacobian.mT @ torch.linalg.inv(spread)
    shift = (gain @ residual.unsqueeze(-1)).squeeze(-1)
    torch.testing.assert_close(correction.of_mean(residual), shift)

    shrinkage = correction.of_covariance()
    torch.testing.assert_close(shrinkage, gain @ spread @ gain.mT)
    torch.testing.assert_close(shrinkage, shrinkage.mT, rtol=1e-14, atol=1e-14)

    mahalanobis = residual.unsqueeze(-2) @ torch.linalg.inv(spread) @ residual.unsqueeze(-1)
    squared_distance = correction.squared_distance(residual)
    torch.testing.assert_close(squared_distance, mahalanobis.squeeze(-1).squeeze(-1))


@pytest.mark.parametrize("rows", [1, 2])
def test_single_precision_knows_what_double_does_of_what_is_measured_well(rows: int) -> None:
    """A prior of 10 m, and then, one after the other, readings of a millimetre on all sides."""
    known: dict[torch.dtype, torch.Tensor] = {}
    for dtype in DTYPES:
        covariance = 100.0 * torch.eye(3, dtype=dtype)
        noise = 1e-6 * torch.eye(rows, dtype=dtype)
        for seed in range(6):
            jacobian = normal(rows, 3, seed=seed).to(dtype)
            correction = Correction.by(covariance, jacobian, noise)
            covariance = correction.corrected(covariance, jacobian, noise)
        known[dtype] = torch.linalg.eigvalsh(covariance.double())

    # The difference P − K S Kᵀ has negative ones, or some a hundred times too small.
    share = known[torch.float32] / known[torch.float64]
    assert (share > 0.25).all() and (share < 4.0).all()


def test_the_distance_divides_by_the_spread() -> None:
    """νᵀS⁻¹ν, not νᵀSν: a residual of 2 with S = 16 is 0.25 away."""
    one = torch.ones(1, 1, dtype=torch.float64)
    correction = Correction.by(12.0 * one, one, 4.0 * one)
    assert float(correction.squared_distance(2.0 * one[0])) == pytest.approx(0.25)


def test_a_detached_gain_carries_no_gradient() -> None:
    covariance = random_covariance(size=2).requires_grad_()
    residual = normal(1, seed=1).requires_grad_()
    noise = torch.ones(1, 1, dtype=torch.float64)
    correction = Correction.by(covariance, normal(1, 2, seed=2), noise)

    shift = correction.of_mean(residual, detach_gain=True).sum()
    slopes = torch.autograd.grad(shift, (covariance, residual), allow_unused=True)
    assert slopes[0] is None
    torch.testing.assert_close(slopes[1], correction.gain.sum(-1).detach())

    (slope,) = torch.autograd.grad(correction.of_mean(residual).sum(), covariance)
    assert slope.any()
