"""Gradient shaping: values from one place, gradients from another."""

import pytest
import torch
from _inputs import BATCHES, normal

from aicon_torch import by_sign, straight_through, straight_through_clamp


@pytest.mark.parametrize("batch", BATCHES, ids=str)
def test_straight_through_has_the_value_of_one_and_the_gradient_of_the_other(batch: tuple[int, ...]) -> None:
    measured, x = normal(*batch, 2, seed=1).requires_grad_(), normal(*batch, 2, seed=2).requires_grad_()
    shaped = straight_through(measured, x**2)
    torch.testing.assert_close(shaped, measured)
    by_measured, by_x = torch.autograd.grad(shaped.sum(), (measured, x), allow_unused=True)
    assert by_measured is None
    torch.testing.assert_close(by_x, 2 * x)


def test_straight_through_clamp_steers_though_saturated() -> None:
    x = torch.tensor([-2.0, 0.3, 5.0], dtype=torch.float64, requires_grad=True)
    shaped = straight_through_clamp(x, -1.0, 1.0)
    torch.testing.assert_close(shaped, x.clamp(-1.0, 1.0))
    (slope,) = torch.autograd.grad((3.0 * shaped).sum(), x)
    assert slope.tolist() == [3.0, 3.0, 3.0]
    (plain,) = torch.autograd.grad((3.0 * x.clamp(-1.0, 1.0)).sum(), x)
    assert plain.tolist() == [0.0, 3.0, 0.0]


@pytest.mark.parametrize("batch", BATCHES, ids=str)
def test_by_sign_chooses_the_derivative_by_what_arrives(batch: tuple[int, ...]) -> None:
    positive, negative = normal(*batch, 4, seed=1).requires_grad_(), normal(*batch, 4, seed=2).requires_grad_()
    shaped = by_sign(positive, negative)
    torch.testing.assert_close(shaped, negative)
    arriving = normal(*batch, 4, seed=3)
    up, down = torch.autograd.grad(shaped, (positive, negative), arriving)
    assert torch.equal(up, torch.where(arriving > 0, arriving, 0.0))
    assert torch.equal(down, torch.where(arriving > 0, 0.0, arriving))


def test_by_sign_of_equal_branches_is_the_identity() -> None:
    x = normal(5).requires_grad_()
    arriving = normal(5, seed=1)
    (slope,) = torch.autograd.grad(by_sign(x, x), x, arriving)
    torch.testing.assert_close(slope, arriving)
