"""Gradient shaping: values from one place, gradients from another."""

import math
from collections.abc import Callable
from typing import NamedTuple

import pytest
import torch
from _inputs import BATCHES, DTYPES, normal
from torch import Tensor

from aicon_torch import by_gain, by_sign, straight_through, straight_through_clamp


@pytest.mark.parametrize("batch", BATCHES, ids=str)
def test_straight_through_has_the_value_of_one_and_the_gradient_of_the_other(
    batch: tuple[int, ...],
) -> None:
    measured = normal(*batch, 2, seed=1).requires_grad_()
    x = normal(*batch, 2, seed=2).requires_grad_()
    shaped = straight_through(measured, x**2)
    torch.testing.assert_close(shaped, measured)

    by_measured, by_x = torch.autograd.grad(shaped.sum(), (measured, x), allow_unused=True)
    assert by_measured is None
    torch.testing.assert_close(by_x, 2 * x)


def test_straight_through_clamp_steers_though_saturated() -> None:
    x = torch.tensor([-2.0, 0.3, 5.0], dtype=torch.float64, requires_grad=True)
    shaped, plain = straight_through_clamp(x, -1.0, 1.0), x.clamp(-1.0, 1.0)
    torch.testing.assert_close(shaped, plain)

    (slope,) = torch.autograd.grad((3.0 * shaped).sum(), x)
    assert slope.tolist() == [3.0, 3.0, 3.0]

    (slope,) = torch.autograd.grad((3.0 * plain).sum(), x)
    assert slope.tolist() == [0.0, 3.0, 0.0]


# --- by sign


@pytest.mark.parametrize("batch", BATCHES, ids=str)
def test_by_sign_chooses_the_derivative_by_what_arrives(batch: tuple[int, ...]) -> None:
    positive = normal(*batch, 4, seed=1).requires_grad_()
    negative = normal(*batch, 4, seed=2).requires_grad_()
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


# --- by gain


class Inputs(NamedTuple):
    """What is shaped by gain, or the gradients by it: effects and two weights of each."""

    effects: Tensor
    intended: Tensor
    incidental: Tensor


def inputs(
    *batch: int, count: int = 4, size: int = 3, dtype: torch.dtype = torch.float64
) -> tuple[Inputs, Tensor]:
    """Effects ``(*B, n, d)`` with weights, and an arriving gradient ``(*B, d)``.

    Some of the effects lower its cost, and some raise it.
    """
    effects = normal(*batch, count, size, seed=1, dtype=dtype).requires_grad_()
    intended = normal(*batch, count, seed=2, dtype=dtype).abs().requires_grad_()
    incidental = (normal(*batch, count, seed=3, dtype=dtype).abs() + 2.0).requires_grad_()

    return Inputs(effects, intended, incidental), normal(*batch, size, seed=5, dtype=dtype)


def gradients(leaves: Inputs, arriving: Tensor, softness: float = 0.0) -> Inputs:
    """The gradients by effects and weights."""
    shaped = by_gain(*leaves, softness)
    return Inputs(*torch.autograd.grad(shaped, leaves, arriving))


@pytest.mark.parametrize("dtype", DTYPES, ids=str)
@pytest.mark.parametrize("softness", [0.0, 0.1, 10.0])
@pytest.mark.parametrize("batch", BATCHES, ids=str)
def test_by_gain_has_the_value_of_what_is_sought(
    batch: tuple[int, ...], softness: float, dtype: torch.dtype
) -> None:
    leaves, arriving = inputs(*batch, dtype=dtype)
    shaped = by_gain(*leaves, softness)
    assert shaped.shape == arriving.shape and shaped.dtype == dtype
    intended = torch.einsum("...n,...nd->...d", leaves.intended, leaves.effects)
    torch.testing.assert_close(shaped, intended)

    for gradient in gradients(leaves, arriving, softness):
        assert gradient.dtype == dtype and gradient.isfinite().all()


@pytest.mark.parametrize("softness", [0.0, 0.3, 5.0])
@pytest.mark.parametrize("batch", BATCHES, ids=str)
def test_by_gain_weighs_each_effect_by_whether_it_is_wanted(
    batch: tuple[int, ...], softness: float
) -> None:
    """w = s·intended + (1 − s)·incidental with s = σ(−b/T), for one effect after the other."""
    leaves, arriving = inputs(*batch)
    found = gradients(leaves, arriving, softness)
    assert_weighed(leaves, arriving, found, softness)


def assert_weighed(leaves: Inputs, arriving: Tensor, found: Inputs, softness: float) -> None:
    effects, intended, incidental = (leaf.detach() for leaf in leaves)
    signs: set[bool] = set()

    for index in torch.cartesian_prod(*map(torch.arange, intended.shape)).reshape(
        -1, intended.dim()
    ):
        effect = tuple(index.tolist())
        gain = float((arriving[effect[:-1]] * effects[effect]).sum())
        share = float(gain < 0) if softness == 0 else 1.0 / (1.0 + math.exp(gain / softness))
        weight = share * float(intended[effect]) + (1.0 - share) * float(incidental[effect])

        torch.testing.assert_close(found.effects[effect], weight * arriving[effect[:-1]])
        assert float(found.intended[effect]) == pytest.approx(share * gain, abs=1e-12)
        assert float(found.incidental[effect]) == pytest.approx((1.0 - share) * gain, abs=1e-12)
        signs.add(gain < 0)

    assert signs == {True, False}


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_by_gain_is_the_derivative_of_the_branch_that_it_chose(sign: float) -> None:
    """That of Σ wᵢ eᵢ·h, with w the intended weight where eᵢ·h < 0, and else the incidental one."""
    leaves, arriving = inputs()
    arriving = sign * arriving
    found = gradients(leaves, arriving)

    wanted = (leaves.effects @ arriving < 0).detach()
    assert wanted.any() and not wanted.all()

    def branch(effects: Tensor, intended: Tensor, incidental: Tensor) -> Tensor:
        return (torch.where(wanted, intended, incidental) * (effects @ arriving)).sum()

    for index, gradient in enumerate(found):
        expected = central_differences_of(branch, leaves, index)
        torch.testing.assert_close(gradient, expected, rtol=0.0, atol=1e-7)


def central_differences_of(function: Callable[..., Tensor], point: Inputs, index: int) -> Tensor:
    """The derivative by one of several arguments, component by component."""
    where = [tensor.detach() for tensor in point]
    flat = where[index].flatten()
    slope = torch.zeros_like(flat)

    for component in range(len(flat)):
        ends: list[Tensor] = []
        for step in (1e-6, -1e-6):
            moved = flat.clone()
            moved[component] += step
            arguments = [*where[:index], moved.reshape(where[index].shape), *where[index + 1 :]]
            ends.append(function(*arguments))
        slope[component] = (ends[0] - ends[1]) / 2e-6

    return slope.reshape(where[index].shape)


def test_the_choice_flips_with_the_arriving_gradient() -> None:
    """What is wanted is unwanted where the opposite is wanted.

    Each weight gets a gradient from one of the two.
    """
    leaves, arriving = inputs(5)
    there, back = gradients(leaves, arriving), gradients(leaves, -arriving)

    torch.testing.assert_close(there.intended, -back.incidental)
    torch.testing.assert_close(there.incidental, -back.intended)
    assert there.intended.any() and there.incidental.any()
    assert not (there.intended * there.incidental).any()


@pytest.mark.parametrize("softness", [1e-2, 1e-4, 1e-8])
def test_a_hard_choice_is_the_limit_of_a_soft_one(softness: float) -> None:
    leaves, arriving = inputs(20)
    gap = (leaves.effects.detach() * arriving.unsqueeze(-2)).sum(-1).abs().min()
    bound = 4.0 * float(torch.exp(-gap / softness)) * 20.0
    assert softness > 1e-3 or bound < 1e-3

    hard, soft = gradients(leaves, arriving), gradients(leaves, arriving, softness)
    for first, second in zip(hard, soft, strict=True):
        torch.testing.assert_close(first, second, rtol=0, atol=bound + 1e-12)


@pytest.mark.parametrize("softness", [0.0, 0.5])
def test_by_gain_of_equal_weights_is_the_plain_sum(softness: float) -> None:
    """Then there is no choice, and it is a function like any other.

    Its derivatives are those of autograd.
    """
    (effects, weights, _), arriving = inputs(2)

    def shaped(effects: Tensor, weights: Tensor) -> Tensor:
        return by_gain(effects, weights, weights, softness)

    assert torch.autograd.gradcheck(shaped, (effects, weights))

    plain = (weights.unsqueeze(-1) * effects).sum(-2)
    expected = torch.autograd.grad(plain, (effects, weights), arriving)
    found = torch.autograd.grad(shaped(effects, weights), (effects, weights), arriving)
    torch.testing.assert_close(found, expected)


@pytest.mark.parametrize(("softness", "weight"), [(0.0, 2.0), (0.7, 3.5)])
def test_an_effect_without_a_gain_pulls_incidentally(softness: float, weight: float) -> None:
    """b = 0 lowers nothing; half and half where the choice is soft."""
    effect = torch.tensor([[0.0, 1.0]], dtype=torch.float64, requires_grad=True)
    arriving = torch.tensor([1.0, 0.0], dtype=torch.float64)
    intended, incidental = torch.tensor([[5.0], [2.0]], dtype=torch.float64)

    shaped = by_gain(effect, intended, incidental, softness)
    (gradient,) = torch.autograd.grad(shaped, effect, arriving)
    torch.testing.assert_close(gradient, weight * arriving.unsqueeze(0))


@pytest.mark.parametrize("softness", [0.0, 0.3])
def test_rows_of_a_batch_choose_alone(softness: float) -> None:
    leaves, arriving = inputs(6)
    together = gradients(leaves, arriving, softness)

    for row in range(6):
        own = Inputs(*(leaf[row].detach().requires_grad_() for leaf in leaves))
        alone = gradients(own, arriving[row], softness)
        torch.testing.assert_close(Inputs(*(gradient[row] for gradient in together)), alone)
