"""Kalman corrections against the textbook's formulas."""

import pytest
import torch
from _inputs import BATCHES, normal, random_covariance

from aicon_torch.estimation import Correction


@pytest.mark.parametrize("batch", BATCHES, ids=str)
@pytest.mark.parametrize("rows", [1, 2, 3])
def test_a_correction_is_the_textbook_s(batch: tuple[int, ...], rows: int) -> None:
    p, noise = random_covariance(*batch, size=3), random_covariance(*batch, size=rows, seed=1)
    residual, jacobian = normal(*batch, rows, seed=2), normal(*batch, rows, 3, seed=3)
    step = Correction.by(p, jacobian, noise)
    spread = jacobian @ p @ jacobian.mT + noise
    gain = p @ jacobian.mT @ torch.linalg.inv(spread)

    torch.testing.assert_close(step.of_mean(residual), (gain @ residual.unsqueeze(-1)).squeeze(-1))
    torch.testing.assert_close(step.of_covariance(), gain @ spread @ gain.mT)
    torch.testing.assert_close(
        step.of_covariance(), step.of_covariance().mT, rtol=1e-14, atol=1e-14
    )

    mahalanobis = residual.unsqueeze(-2) @ torch.linalg.inv(spread) @ residual.unsqueeze(-1)
    torch.testing.assert_close(step.distance(residual), mahalanobis.squeeze(-1).squeeze(-1))


def test_the_distance_divides_by_the_spread() -> None:
    """νᵀS⁻¹ν, not νᵀSν: a residual of 2 with S = 16 is 0.25 away."""
    one = torch.ones(1, 1, dtype=torch.float64)
    step = Correction.by(12.0 * one, one, 4.0 * one)
    assert float(step.distance(torch.tensor([2.0], dtype=torch.float64))) == pytest.approx(0.25)


def test_a_detached_gain_carries_no_gradient() -> None:
    p, residual = random_covariance(size=2).requires_grad_(), normal(1, seed=1).requires_grad_()
    step = Correction.by(p, normal(1, 2, seed=2), torch.ones(1, 1, dtype=torch.float64))
    by_p, by_residual = torch.autograd.grad(
        step.of_mean(residual, detach_gain=True).sum(), (p, residual), allow_unused=True
    )

    assert by_p is None
    torch.testing.assert_close(by_residual, step.gain.sum(-1).detach())
    assert torch.autograd.grad(step.of_mean(residual).sum(), p)[0].any()
