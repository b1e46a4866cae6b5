"""Gradient shaping: values from one place, gradients from another."""

import math

import pytest
import torch
from _inputs import BATCHES, DTYPES, normal
from torch import Tensor

from aicon_torch import by_gain, by_sign, straight_through, straight_through_clamp


@pytest.mark.parametrize("batch", BATCHES, ids=str)
def test_straight_through_has_the_value_of_one_and_the_gradient_of_the_other(
    batch: tuple[int, ...],
) -> None:
    measured, x = (
        normal(*batch, 2, seed=1).requires_grad_(),
        normal(*batch, 2, seed=2).requires_grad_(),
    )
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
    positive, negative = (
        normal(*batch, 4, seed=1).requires_grad_(),
        normal(*batch, 4, seed=2).requires_grad_(),
    )
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


def effects(
    *batch: int, count: int = 4, size: int = 3, dtype: torch.dtype = torch.float64
) -> tuple[Tensor, ...]:
    """Effects, two weights each, and an arriving gradient that some lower the cost of and some
    raise it.
    """
    found = (
        normal(*batch, count, size, seed=1, dtype=dtype),
        normal(*batch, count, seed=2, dtype=dtype).abs(),
        normal(*batch, count, seed=3, dtype=dtype).abs() + 2.0,
    )
    return (
        *(tensor.requires_grad_() for tensor in found),
        normal(*batch, size, seed=5, dtype=dtype),
    )


@pytest.mark.parametrize("dtype", DTYPES, ids=str)
@pytest.mark.parametrize("softness", [0.0, 0.1, 10.0])
@pytest.mark.parametrize("batch", BATCHES, ids=str)
def test_by_gain_has_the_value_of_what_is_sought(
    batch: tuple[int, ...], softness: float, dtype: torch.dtype
) -> None:
    e, sought, incidental, arriving = effects(*batch, dtype=dtype)
    shaped = by_gain(e, sought, incidental, softness)
    assert shaped.shape == arriving.shape and shaped.dtype == dtype
    torch.testing.assert_close(shaped, torch.einsum("...n,...nd->...d", sought, e))
    for slope in torch.autograd.grad(shaped, (e, sought, incidental), arriving):
        assert slope.dtype == dtype and slope.isfinite().all()


@pytest.mark.parametrize("softness", [0.0, 0.3, 5.0])
@pytest.mark.parametrize("batch", BATCHES, ids=str)
def test_by_gain_weighs_each_effect_by_whether_it_is_wanted(
    batch: tuple[int, ...], softness: float
) -> None:
    """w = s·sought + (1 − s)·incidental with s = σ(−b/T), written out for one effect after the
    other.
    """
    e, sought, incidental, arriving = effects(*batch)
    slopes = torch.autograd.grad(
        by_gain(e, sought, incidental, softness), (e, sought, incidental), arriving
    )
    tensors = [tensor.detach() for tensor in (e, sought, incidental, arriving, *slopes)]
    stacks = [tensor.reshape(-1, *tensor.shape[len(batch) :]) for tensor in tensors]
    signs = set()
    for e_, sought_, incidental_, h, by_e, by_sought, by_incidental in zip(*stacks, strict=True):
        for i in range(4):
            gain = float((h * e_[i]).sum())
            share = float(gain < 0) if softness == 0 else 1.0 / (1.0 + math.exp(gain / softness))
            weight = share * float(sought_[i]) + (1.0 - share) * float(incidental_[i])
            torch.testing.assert_close(by_e[i], weight * h)
            assert float(by_sought[i]) == pytest.approx(share * gain, abs=1e-12)
            assert float(by_incidental[i]) == pytest.approx((1.0 - share) * gain, abs=1e-12)
            signs.add(gain < 0)
    assert signs == {True, False}


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_by_gain_is_the_derivative_of_the_branch_that_it_chose(sign: float) -> None:
    """Central differences of Σ wᵢ eᵢ·h, with w the sought weight where eᵢ·h < 0 and the incidental
    one elsewhere.
    """
    e, sought, incidental, arriving = effects()
    arriving = sign * arriving
    slopes = torch.autograd.grad(by_gain(e, sought, incidental), (e, sought, incidental), arriving)
    wanted = (e @ arriving < 0).detach()
    assert wanted.any() and not wanted.all()

    def branch(e: Tensor, sought: Tensor, incidental: Tensor) -> Tensor:
        return (torch.where(wanted, sought, incidental) * (e @ arriving)).sum()

    point = [tensor.detach() for tensor in (e, sought, incidental)]
    for index, slope in enumerate(slopes):
        for k in range(slope.numel()):
            shift = torch.zeros(slope.numel(), dtype=torch.float64).index_fill(
                0, torch.tensor(k), 1e-6
            )
            ends = [
                branch(
                    *(
                        x + s * shift.reshape(x.shape) if i == index else x
                        for i, x in enumerate(point)
                    )
                )
                for s in (1.0, -1.0)
            ]
            assert float(slope.flatten()[k]) == pytest.approx(
                float(ends[0] - ends[1]) / 2e-6, abs=1e-7
            )


def test_the_choice_flips_with_the_arriving_gradient() -> None:
    """What is wanted is unwanted where the opposite is wanted.

    Each weight gets a gradient from one of the two.
    """
    e, sought, incidental, arriving = effects(5)
    shaped = by_gain(e, sought, incidental)
    there, back = (
        torch.autograd.grad(shaped, (sought, incidental), sign * arriving, retain_graph=True)
        for sign in (1.0, -1.0)
    )
    for first, second in ((there[0], back[1]), (there[1], back[0])):
        torch.testing.assert_close(first, -second)
        assert first.any()
    assert not (there[0] * there[1]).any()


@pytest.mark.parametrize("softness", [1e-2, 1e-4, 1e-8])
def test_a_hard_choice_is_the_limit_of_a_soft_one(softness: float) -> None:
    e, sought, incidental, arriving = effects(20)
    gap = (e * arriving.unsqueeze(-2)).sum(-1).abs().min()
    hard, soft = (
        torch.autograd.grad(by_gain(e, sought, incidental, t), (e, sought, incidental), arriving)
        for t in (0.0, softness)
    )
    bound = 4.0 * float(torch.exp(-gap.detach() / softness)) * 20.0
    for first, second in zip(hard, soft, strict=True):
        torch.testing.assert_close(first, second, rtol=0, atol=bound + 1e-12)
    assert softness > 1e-3 or bound < 1e-3


def test_by_gain_of_equal_weights_is_the_plain_sum() -> None:
    """Then there is no choice, and it is a function like any other.

    Its derivatives are those of autograd.
    """
    e, sought, _, arriving = effects(2)
    for softness in (0.0, 0.5):
        assert torch.autograd.gradcheck(lambda e, w, t=softness: by_gain(e, w, w, t), (e, sought))
    slopes = torch.autograd.grad(by_gain(e, sought, sought), (e, sought), arriving)
    plain = torch.autograd.grad((sought.unsqueeze(-1) * e).sum(-2), (e, sought), arriving)
    for first, second in zip(slopes, plain, strict=True):
        torch.testing.assert_close(first, second)


def test_an_effect_without_a_gain_pulls_incidentally() -> None:
    """b = 0 lowers nothing; half and half where the choice is soft."""
    e = torch.tensor([[0.0, 1.0]], dtype=torch.float64, requires_grad=True)
    arriving = torch.tensor([1.0, 0.0], dtype=torch.float64)
    weights = [torch.tensor([weight], dtype=torch.float64) for weight in (5.0, 2.0)]
    for softness, weight in ((0.0, 2.0), (0.7, 3.5)):
        (slope,) = torch.autograd.grad(by_gain(e, weights[0], weights[1], softness), e, arriving)
        torch.testing.assert_close(slope, weight * arriving.unsqueeze(0))


@pytest.mark.parametrize("softness", [0.0, 0.3])
def test_rows_of_a_batch_choose_alone(softness: float) -> None:
    e, sought, incidental, arriving = effects(6)
    together = torch.autograd.grad(
        by_gain(e, sought, incidental, softness), (e, sought, incidental), arriving
    )
    for row in range(6):
        leaves = [tensor[row].detach().requires_grad_() for tensor in (e, sought, incidental)]
        alone = torch.autograd.grad(by_gain(*leaves, softness), leaves, arriving[row])
        for whole, one in zip(together, alone, strict=True):
            torch.testing.assert_close(whole[row], one)
