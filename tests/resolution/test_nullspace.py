"""The nullspace projection: what each rank takes, and what it leaves alone."""

import math
from typing import Any

import pytest
import torch
from _asserts import assert_orthogonal, selection
from _inputs import (
    BATCHES,
    PROJECTORS,
    RANDOM,
    STACKS,
    direction,
    for_each,
    fresh,
    lengths,
    normal,
    projection_in_paper,
    resolve,
    resolved,
    selected,
    unweighted,
    weighted,
)
from torch import Tensor

from aicon_torch import NullspaceProjection, OptionError, SteepestPath, TrapEscape


@for_each("stack", STACKS)
@pytest.mark.parametrize("projector", PROJECTORS)
def test_resolved_gradients_are_mutually_orthogonal(stack: Tensor, projector: Any) -> None:
    vectors, _ = selected(unweighted(projector=projector), stack)

    length = lengths(vectors)
    largest = length.amax(-1, keepdim=True)
    assert_orthogonal(vectors, (largest * largest).unsqueeze(-1))

    # In a degenerate stack a remainder of rounding is no direction.
    if any(stack is random for random in RANDOM.values()):
        assert_orthogonal(vectors, length.unsqueeze(-1) * length.unsqueeze(-2))


def test_a_goal_that_asks_for_nothing_takes_no_rank() -> None:
    """Not even one that held it before."""
    rule = projection_in_paper()
    gradients = torch.tensor([[0.0, 0.0], [0.05, 0.0], [0.0, 0.04]], dtype=torch.float64)
    memory = fresh(rule, gradients) | {"rank": torch.tensor([0, 1])}
    _, after = resolve(rule, gradients, memory)
    assert after["rank"].tolist() == [1, 2]

    opposed = torch.tensor([[0.0, 0.0], [0.05, 0.0], [-0.05, 0.001]], dtype=torch.float64)
    _, after = resolve(rule, opposed, memory)
    assert after["exploring"]


@for_each("stack", STACKS)
def test_a_gradient_never_changes_what_those_before_it_decided(stack: Tensor) -> None:
    """What rank i adds is orthogonal to every *original* gradient of a higher rank.

    So to first order the motion −Σ lowers the cost of the top gradient exactly as its own descent
    would, and what any rank adds to the motion leaves the costs of all ranks above it where they
    are.
    """
    vectors, order = selected(unweighted(), stack)
    original = stack.take_along_dim(order.clamp(min=0).unsqueeze(-1), dim=-2)  # −1: none, zero
    scale = lengths(stack).amax(-1)

    for rank in range(1, vectors.shape[-2]):
        work = (vectors[..., rank : rank + 1, :] * original[..., :rank, :]).sum(-1)
        assert (work.abs() <= 1e-12 * (scale**2).unsqueeze(-1)).all()

    # The sum's part along each resolved gradient is that gradient itself.
    total = vectors.sum(-2)
    for rank in range(vectors.shape[-2]):
        part = (total * vectors[..., rank, :]).sum(-1)
        own = (vectors[..., rank, :] ** 2).sum(-1)
        assert ((part - own).abs() <= 1e-12 * scale**2).all()
        assert (part >= -1e-12 * scale**2).all()


@for_each("stack", RANDOM)
@pytest.mark.parametrize("margin", [0.0, 0.1])
def test_selection_agrees_with_plain_loops(stack: Tensor, margin: float) -> None:
    """Eq. 7-8 written out, projecting onto the complement of a span by least squares."""
    rows = stack.reshape(-1, *stack.shape[-2:])
    generator = torch.Generator().manual_seed(0)
    held = torch.randint(
        -1, stack.shape[-2], (len(rows), min(stack.shape[-2:])), generator=generator
    )

    taken, order = unweighted(margin=margin).project_in_order(rows, lengths(rows), held)

    for row, gradients in enumerate(rows):
        vectors, chosen = selection(gradients, held[row], margin)
        assert order[row].tolist() == chosen
        torch.testing.assert_close(taken[row].sum(0), vectors.sum(0), rtol=1e-10, atol=1e-12)


@pytest.mark.parametrize("dimension", [1, 2, 4])
def test_orthogonal_gradients_are_simply_added(dimension: int) -> None:
    rotations = torch.linalg.qr(normal(3, dimension, dimension)).Q
    stack = rotations * torch.arange(1.0, dimension + 1).unsqueeze(-1)

    total = resolved(unweighted(), stack)
    torch.testing.assert_close(total, stack.sum(-2), rtol=1e-10, atol=1e-12)


@pytest.mark.parametrize("size", [1, 3], ids=["in one dimension", "along one line"])
def test_parallel_gradients_are_not_counted_twice(size: int) -> None:
    """The strongest alone acts."""
    stack = normal(4, 5, 1) * (normal(size) if size > 1 else 1.0)

    longest = resolved(SteepestPath(), stack)
    torch.testing.assert_close(resolved(unweighted(), stack), longest, rtol=1e-9, atol=1e-9)


def test_projection_removes_what_would_interfere() -> None:
    """Two gradients in the plane, by hand: (3, 4) leads, (1, 0) loses its component along it."""
    stack = torch.tensor([[1.0, 0.0], [3.0, 4.0]], dtype=torch.float64)
    expected = torch.tensor([3.0 + 0.64, 4.0 - 0.48], dtype=torch.float64)
    torch.testing.assert_close(resolved(unweighted(), stack), expected)


@pytest.mark.parametrize("batch", BATCHES, ids=str)
def test_a_single_gradient_passes(batch: tuple[int, ...]) -> None:
    stack = normal(*batch, 1, 3)
    alone = stack[..., 0, :]

    torch.testing.assert_close(resolved(unweighted(), stack), alone)
    torch.testing.assert_close(resolved(weighted(), stack), direction(alone))


# --- options


@pytest.mark.parametrize(
    ("options", "culprit"),
    [
        ({"temperature": 0.0}, "temperature"),
        ({"temperature": -1.0}, "temperature"),
        ({"temperature": math.nan}, "temperature"),
        ({"margin": -0.1}, "margin"),
        ({"margin": "a"}, "margin='a'"),
        ({"exploration": "none"}, "exploration='none': expected Exploration"),
        ({"projector": "ortho"}, "'orthogonal', 'qr', 'pinv', 'none'"),
    ],
)
def test_bad_options_are_named(options: dict[str, Any], culprit: str) -> None:
    with pytest.raises(OptionError, match=culprit):
        NullspaceProjection(**options)


def test_the_paper_s_options_are_those_of_the_text() -> None:
    rule = projection_in_paper()
    assert (rule.temperature, rule.margin) == (0.8, 0.1)
    assert (rule.restore_magnitude, rule.relative, rule.by_row) == (False, False, False)

    exploration = rule.exploration
    assert exploration is not None and exploration.escape == TrapEscape()
    assert (exploration.enter_cosine, exploration.exit_cosine) == (-0.6, -0.4)
    assert (exploration.ratio, exploration.opponent) == (3.0, "second")
    assert exploration.ratio_of == "weights"
