"""Properties of the nullspace projection on drawn stacks: parallel, opposed, zero and duplicate gradients included."""

from typing import Any

import pytest
import torch
from hypothesis import assume, given
from hypothesis import strategies as st
from torch import Tensor

from aicon_torch import NullspaceProjection
from aicon_torch.vectors import unit

RULES = [{"temperature": 0.8}, {"temperature": None}, {"temperature": 0.8, "relative": True}]


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
        else:
            rows.append([0.0] * size if kind == "zero" else draw(st.lists(number, min_size=size, max_size=size)))
    return torch.tensor(rows, dtype=torch.float64)


def resolved(stack: Tensor, **options: Any) -> tuple[Tensor, Tensor]:
    """The sum ``(d,)`` and who holds which rank, without a history."""
    rule = NullspaceProjection(exploration=None, **options)
    norms = torch.linalg.vector_norm(stack, dim=-1)
    weights = rule.weigh(norms)
    taken, rank = rule.resolve(unit(stack) * weights.unsqueeze(-1), weights, rule.initial(*stack.shape)["rank"])
    return taken.sum(-2), rank


@pytest.mark.parametrize("options", RULES, ids=str)
@given(stacks())
def test_no_gradient_raises_the_cost_of_one_before_it(options: dict[str, Any], stack: Tensor) -> None:
    """Descending the sum lowers the leader's cost as if it were alone, and each next one's in the space left to it."""
    total, rank = resolved(stack, **options)
    weights = NullspaceProjection(exploration=None, **options).weigh(torch.linalg.vector_norm(stack, dim=-1))
    left = unit(stack) * weights.unsqueeze(-1)
    for index in [index for index in rank.tolist() if index >= 0]:
        selected = left[index].clone()
        scale = float(weights.max()) ** 2
        assert float(total @ selected) == pytest.approx(float(selected @ selected), abs=1e-9 * scale)
        left = left - (left @ unit(selected)).unsqueeze(-1) * unit(selected)


@given(stacks())
def test_the_three_projectors_are_equal(stack: Tensor) -> None:
    norms = torch.linalg.vector_norm(stack, dim=-1)
    assume(not ((norms > 0) & (norms < 1e-2)).any())
    total, rank = resolved(stack)
    for projector in ("qr", "pinv"):
        other, held = resolved(stack, projector=projector)
        if torch.equal(held, rank):  # what is left of parallel gradients is rounding, and so is its order
            torch.testing.assert_close(other, total, rtol=1e-9, atol=1e-10)
        torch.testing.assert_close(other, total, rtol=1e-6, atol=1e-7)


@given(stacks(), st.randoms(use_true_random=False))
def test_the_order_of_the_candidates_does_not_matter(stack: Tensor, random: Any) -> None:
    norms = torch.linalg.vector_norm(stack, dim=-1)
    gaps = (norms.unsqueeze(0) - norms.unsqueeze(1)).abs() + torch.eye(len(norms), dtype=norms.dtype)
    assume(bool((gaps > 1e-3).all()))  # who leads among equals is nobody's business
    order = list(range(len(stack)))
    random.shuffle(order)
    total, rank = resolved(stack)
    other, held = resolved(stack[order])
    assume([order[i] if i >= 0 else -1 for i in held.tolist()] == rank.tolist())  # equal projections may swap
    torch.testing.assert_close(other, total, rtol=1e-9, atol=1e-10)


@given(stacks(), st.integers(1, 3))
def test_rows_of_a_batch_are_resolved_alone(stack: Tensor, copies: int) -> None:
    rule = NullspaceProjection(exploration=None)
    batch = torch.stack([stack * (k + 1) for k in range(copies)])
    weights = rule.weigh(torch.linalg.vector_norm(batch, dim=-1))
    held = rule.initial(*stack.shape)["rank"].expand(copies, -1)
    together, _ = rule.resolve(unit(batch) * weights.unsqueeze(-1), weights, held)
    alone = torch.stack([resolved(row)[0] for row in batch])
    torch.testing.assert_close(together.sum(-2), alone, rtol=1e-12, atol=1e-12)
