"""Every rule on every stack: properties of the step from many gradients to one."""

from functools import partial

import pytest
import torch
from _asserts import assert_same_but_for_roundings
from _inputs import (
    DTYPES,
    PROJECTORS,
    RANDOM,
    STACKS,
    for_each,
    fresh,
    gradient_stack,
    lengths,
    normal,
    projection_in_paper,
    ranks,
    resolved,
    unweighted,
    weighted,
)
from torch import Tensor

from aicon_torch import NullspaceProjection, Resolution, SteepestPath, Sum

PURSUING: dict[str, Resolution] = {
    "sum": Sum(),
    "steepest": SteepestPath(),
    "weighted": weighted(),
    "unweighted": unweighted(),
}
"""Rules that only pursue the goals."""

PROJECTED = {f"projected by {name}": weighted(projector=name) for name in (*PROJECTORS, "none")}
EXPLORING = {"as in the paper": projection_in_paper(), "as shipped": NullspaceProjection()}
RULES = PURSUING | PROJECTED | EXPLORING

every_rule = pytest.mark.parametrize("rule", RULES.values(), ids=RULES.keys())
every_pursuing_rule = pytest.mark.parametrize("rule", PURSUING.values(), ids=PURSUING.keys())
every_stack = for_each("stack", STACKS)
every_random_stack = for_each("stack", RANDOM)


@every_rule
@every_stack
@pytest.mark.parametrize("dtype", DTYPES, ids=str)
def test_result_is_finite_and_of_the_right_shape_and_type(
    rule: Resolution, stack: Tensor, dtype: torch.dtype
) -> None:
    gradients = stack.to(dtype)
    before = fresh(rule, gradients)
    total, memory = rule(gradient_stack(gradients), before)

    assert total.shape == gradients.shape[:-2] + gradients.shape[-1:]
    assert total.dtype == dtype
    assert total.isfinite().all()

    assert memory.keys() == before.keys()
    for name, value in before.items():
        assert memory[name].shape == value.shape and memory[name].dtype == value.dtype


@every_stack
def test_normalised_result_is_bounded(stack: Tensor) -> None:
    """Orthogonal vectors of lengths that sum to at most one."""
    assert (lengths(resolved(weighted(), stack)) <= 1 + 1e-12).all()


@every_rule
@every_random_stack
def test_rows_of_a_batch_are_resolved_alone(rule: Resolution, stack: Tensor) -> None:
    together = resolved(rule, stack).reshape(-1, stack.shape[-1])

    rows = stack.reshape(-1, *stack.shape[-2:])
    for row, found in zip(rows, together, strict=True):
        assert_same_but_for_roundings(partial(resolved, rule), row, found)


@every_pursuing_rule
@every_random_stack
def test_order_of_the_candidates_does_not_matter(rule: Resolution, stack: Tensor) -> None:
    order = torch.randperm(stack.shape[-2], generator=torch.Generator().manual_seed(1))
    permuted = stack[..., order, :]

    first, second = resolved(rule, permuted), resolved(rule, stack)
    torch.testing.assert_close(first, second, rtol=1e-10, atol=1e-12)

    if isinstance(rule, NullspaceProjection):
        assert torch.equal(order[ranks(rule, permuted)], ranks(rule, stack))


@pytest.mark.parametrize("name", ["sum", "steepest", "unweighted"])
@pytest.mark.parametrize("factor", [1e-6, 3.0, 1e6])
@every_random_stack
def test_without_softmax_the_result_scales_with_the_gradients(
    name: str, factor: float, stack: Tensor
) -> None:
    rule = RULES[name]
    scaled, expected = resolved(rule, factor * stack), factor * resolved(rule, stack)
    torch.testing.assert_close(scaled, expected, rtol=1e-10, atol=0.0)


@every_pursuing_rule
@every_random_stack
def test_result_turns_with_the_gradients(rule: Resolution, stack: Tensor) -> None:
    """No axis is special: a rotation of all gradients rotates the result."""
    rotation = torch.linalg.qr(normal(stack.shape[-1], stack.shape[-1], seed=3)).Q

    turned, expected = resolved(rule, stack @ rotation), resolved(rule, stack) @ rotation
    torch.testing.assert_close(turned, expected, rtol=1e-10, atol=1e-12)
