"""Properties of the nullspace projection on drawn stacks.

Parallel, opposed, zero and duplicate gradients included.
"""

from random import Random

import pytest
import torch
from _asserts import assert_same_but_for_roundings
from _inputs import lengths, resolve, weighted
from hypothesis import assume, given
from hypothesis import strategies as st
from torch import Tensor

from aicon_torch import NullspaceProjection
from aicon_torch.vectors import unit

RULES = {
    "softmax": weighted(),
    "magnitudes": weighted(temperature=None),
    "relative": weighted(relative=True),
}


@st.composite
def stacks(draw: st.DrawFn) -> Tensor:
    """A stack ``(n, d)`` whose rows are drawn, or are zero, or are a multiple of a row before."""
    size = draw(st.integers(1, 4))
    number = st.floats(-100, 100).map(lambda x: round(x, 3))
    rows: list[list[float]] = []

    for _ in range(draw(st.integers(1, 5))):
        kind = draw(st.sampled_from(("drawn", "drawn", "zero", "multiple")))

        if kind == "multiple" and rows:
            factor = draw(st.sampled_from((-2.0, -1.0, 0.5, 1.0)))
            rows.append([factor * x for x in draw(st.sampled_from(rows))])
        elif kind == "zero":
            rows.append([0.0] * size)
        else:
            rows.append(draw(st.lists(number, min_size=size, max_size=size)))

    return torch.tensor(rows, dtype=torch.float64)


def sum_and_ranks(rule: NullspaceProjection, stack: Tensor) -> tuple[Tensor, Tensor]:
    """The sum ``(d,)`` and who holds which rank, without a history."""
    total, memory = resolve(rule, stack)
    return total, memory["rank"]


@pytest.mark.parametrize("rule", RULES.values(), ids=RULES.keys())
@given(stack=stacks())
def test_no_gradient_raises_the_cost_of_one_before_it(
    rule: NullspaceProjection, stack: Tensor
) -> None:
    """Descending the sum lowers the dominant one's cost as if it were alone.

    Each next one's cost falls in the space that is left to it.
    """
    total, rank = sum_and_ranks(rule, stack)
    weights = rule.weigh(lengths(stack))
    scale = float(weights.max()) ** 2

    left = unit(stack) * weights.unsqueeze(-1)
    for index in [index for index in rank.tolist() if index >= 0]:
        dominant = left[index].clone()
        change, alone = float(total @ dominant), float(dominant @ dominant)
        assert change == pytest.approx(alone, abs=1e-9 * scale)

        left = left - (left @ unit(dominant)).unsqueeze(-1) * unit(dominant)


@pytest.mark.parametrize("projector", ["qr", "pinv"])
@given(stack=stacks())
def test_the_three_projectors_are_equal(projector: str, stack: Tensor) -> None:
    norms = lengths(stack)
    assume(not ((norms > 0) & (norms < 1e-2)).any())

    total, rank = sum_and_ranks(weighted(), stack)
    other, other_rank = sum_and_ranks(weighted(projector=projector), stack)
    torch.testing.assert_close(other, total, rtol=1e-6, atol=1e-7)

    # What is left of parallel gradients is rounding, and so is its order.
    if torch.equal(other_rank, rank):
        torch.testing.assert_close(other, total, rtol=1e-9, atol=1e-10)


@given(stacks(), st.randoms(use_true_random=False))
def test_the_order_of_the_candidates_does_not_matter(stack: Tensor, random: Random) -> None:
    norms = lengths(stack)
    gaps = (norms.unsqueeze(0) - norms.unsqueeze(1)).abs()
    gaps.fill_diagonal_(1.0)
    assume(bool((gaps > 1e-3).all()))  # who leads among equals is nobody's business

    order = list(range(len(stack)))
    random.shuffle(order)
    total, rank = sum_and_ranks(weighted(), stack)
    other, permuted = sum_and_ranks(weighted(), stack[order])

    # Equal projections may swap.
    other_rank = [order[index] if index >= 0 else -1 for index in permuted.tolist()]
    assume(other_rank == rank.tolist())

    torch.testing.assert_close(other, total, rtol=1e-9, atol=1e-10)


@given(stacks(), st.integers(1, 3))
def test_rows_of_a_batch_are_resolved_alone(stack: Tensor, copies: int) -> None:
    batch = torch.stack([stack * (k + 1) for k in range(copies)])

    together, _ = sum_and_ranks(weighted(), batch)
    for row, found in zip(batch, together, strict=True):
        assert_same_but_for_roundings(lambda s: sum_and_ranks(weighted(), s)[0], row, found)
