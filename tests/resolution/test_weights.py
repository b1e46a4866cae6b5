"""Normalised magnitudes: the softmax, absolute and relative, and magnitudes that are restored."""

import math

import pytest
import torch
from _inputs import (
    DEGENERATE,
    DTYPES,
    RANDOM,
    for_each,
    fresh,
    gradient_stack,
    lengths,
    normal,
    projection_in_paper,
    resolved,
    unweighted,
    weighted,
)
from torch import Tensor

from aicon_torch import NullspaceProjection

RELATIVE = {
    "relative": weighted(relative=True),
    "relative, exploring": projection_in_paper(relative=True),
}

every_relative_rule = pytest.mark.parametrize("rule", RELATIVE.values(), ids=RELATIVE.keys())
every_random_stack = for_each("stack", RANDOM)
every_degenerate_stack = for_each("stack", DEGENERATE)


# --- softmax


@pytest.mark.parametrize("temperature", [0.1, 0.8, 5.0])
def test_weights_are_the_softmax_of_the_magnitudes(temperature: float) -> None:
    norms = normal(3, 4).abs() + 0.1
    weights = weighted(temperature=temperature).weigh(norms)

    powers = torch.exp(norms / temperature)
    torch.testing.assert_close(weights, powers / powers.sum(-1, keepdim=True))
    torch.testing.assert_close(weights.sum(-1), torch.ones(3, dtype=torch.float64))
    assert torch.equal(weights.argsort(-1), norms.argsort(-1))


def test_two_gradients_are_normalised_before_projection() -> None:
    """Sect. "Stabilizing the Control Signal" by hand: lengths 2 and 1, at right angles, τ = 0.8."""
    stack = torch.tensor([[2.0, 0.0], [0.0, 1.0]], dtype=torch.float64)

    share = 1.0 / (1.0 + math.exp(-1.0 / 0.8))
    expected = torch.tensor([share, 1.0 - share], dtype=torch.float64)
    torch.testing.assert_close(resolved(weighted(), stack), expected)


def test_magnitudes_stay_without_temperature() -> None:
    norms = normal(3, 4).abs()
    assert torch.equal(unweighted().weigh(norms), norms)


@pytest.mark.parametrize("dtype", DTYPES, ids=str)
@pytest.mark.parametrize("length", [1e-10, 1e-25, 1e-40, 1e-200, 1e-310])
def test_a_vanishing_gradient_never_outgrows_its_weight(dtype: torch.dtype, length: float) -> None:
    """Lengths whose squares underflow included.

    The literal text gives them weight, but at most as unit vectors.
    """
    stack = torch.tensor([[length, 2 * length], [1.0, 0.0]], dtype=torch.float64).to(dtype)
    total = resolved(weighted(), stack)

    assert total[0] > 0.5
    assert total.norm() <= 1.0 + 1e-6


# --- relative magnitudes


@every_relative_rule
@every_random_stack
@pytest.mark.parametrize("scale", [1e-9, 1e-3, 1e9])
def test_relative_weights_do_not_depend_on_the_unit(
    rule: NullspaceProjection, stack: Tensor, scale: float
) -> None:
    scaled, expected = resolved(rule, scale * stack), resolved(rule, stack)
    torch.testing.assert_close(scaled, expected, rtol=1e-9, atol=1e-12)

    norms = lengths(stack)
    torch.testing.assert_close(rule.weigh(scale * norms), rule.weigh(norms))

    # A single gradient has nothing to be weighed against.
    if stack.shape[-2] > 1:
        assert not torch.allclose(weighted().weigh(norms), rule.weigh(norms), rtol=1e-3)


@pytest.mark.parametrize("temperature", [0.1, 0.8, 5.0])
def test_relative_weights_are_the_softmax_of_shares_of_the_largest(temperature: float) -> None:
    norms = 30.0 * normal(3, 4).abs()
    weights = weighted(temperature=temperature, relative=True).weigh(norms)

    shares = norms / norms.amax(-1, keepdim=True)
    torch.testing.assert_close(weights, torch.softmax(shares / temperature, dim=-1))
    torch.testing.assert_close(weights.sum(-1), torch.ones(3, dtype=torch.float64))
    assert torch.equal(weights.argsort(-1), norms.argsort(-1))

    largest = weights.amax(-1) / weights.amin(-1)
    assert (largest <= math.exp(1.0 / temperature) * (1 + 1e-12)).all()


@every_relative_rule
@every_degenerate_stack
@pytest.mark.parametrize("dtype", DTYPES, ids=str)
def test_relative_weights_of_degenerate_stacks_are_finite(
    rule: NullspaceProjection, stack: Tensor, dtype: torch.dtype
) -> None:
    gradients = stack.to(dtype)
    assert rule.weigh(lengths(gradients)).isfinite().all()

    total, memory = rule(gradient_stack(gradients), fresh(rule, gradients))
    assert total.isfinite().all() and all(value.isfinite().all() for value in memory.values())
    assert (lengths(total) <= 1 + 1e-6).all()

    if not gradients.any():
        assert not total.any()


@every_random_stack
def test_without_a_softmax_there_is_nothing_relative(stack: Tensor) -> None:
    relative = resolved(unweighted(relative=True), stack)
    assert torch.equal(relative, resolved(unweighted(), stack))


# --- magnitudes where gradients meet again


@every_random_stack
def test_between_meetings_the_leading_gradient_keeps_its_magnitude(stack: Tensor) -> None:
    """The weights compare those that met here.

    Further on, magnitudes are compared with those of others.
    """
    rule = weighted(restore_magnitude=True)
    memory = fresh(rule, stack)
    onward, state = rule(gradient_stack(stack, is_last=False), memory)

    first = stack.take_along_dim(state["rank"][..., :1, None], -2).squeeze(-2)
    length = lengths(first)
    torch.testing.assert_close((onward * first).sum(-1) / length, length)

    last, _ = rule(gradient_stack(stack, is_last=True), memory)
    weight = rule.weigh(lengths(stack)).amax(-1)
    torch.testing.assert_close(onward, last * (length / weight).unsqueeze(-1))

    plain = weighted()
    for is_last in (True, False):
        assert torch.equal(plain(gradient_stack(stack, is_last=is_last), memory)[0], last)


@pytest.mark.parametrize(("is_last", "length"), [(True, 1.0), (False, 2.0)])
def test_between_meetings_exploration_is_as_strong_as_what_led_there(
    is_last: bool, length: float
) -> None:
    stack = torch.tensor([[2.0, 0.0], [-1.9, 0.3]], dtype=torch.float64)
    rule = projection_in_paper(restore_magnitude=True)
    total, state = rule(gradient_stack(stack, is_last=is_last), fresh(rule, stack))

    assert state["exploring"]
    assert float(total.norm()) == pytest.approx(length)


@every_degenerate_stack
def test_restored_magnitudes_are_finite(stack: Tensor) -> None:
    restoring = projection_in_paper(restore_magnitude=True)
    for rule in (weighted(restore_magnitude=True), *RELATIVE.values(), restoring):
        total, _ = rule(gradient_stack(stack, is_last=False), fresh(rule, stack))
        assert total.isfinite().all()
