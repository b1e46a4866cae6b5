"""The projectors are equal, but for the one that does not project."""

from typing import Any

import pytest
import torch
from _inputs import PROJECTORS, STACKS, for_each, normal, resolved, unweighted, weighted
from torch import Tensor


@for_each("stack", STACKS)
@pytest.mark.parametrize("rule", [weighted, unweighted])
def test_the_three_projectors_are_equal(stack: Tensor, rule: Any) -> None:
    orthogonal, qr, pinv = (resolved(rule(projector=name), stack) for name in PROJECTORS)

    # Magnitudes as they are have the size of the stack; normalised ones are at most one.
    scale = max(float(stack.abs().max()), 1e-30) if rule is unweighted else 1.0
    torch.testing.assert_close(orthogonal / scale, qr / scale, rtol=1e-10, atol=1e-10)
    torch.testing.assert_close(orthogonal / scale, pinv / scale, rtol=1e-10, atol=1e-10)


@pytest.mark.parametrize("count", [2, 6])
def test_no_projection_adds_the_gradients_as_they_are(count: int) -> None:
    stack = normal(3, count, 4)
    torch.testing.assert_close(resolved(unweighted(projector="none"), stack), stack.sum(-2))


@pytest.mark.parametrize("projector", PROJECTORS)
@pytest.mark.parametrize("broken", [torch.nan, torch.inf, -torch.inf])
def test_a_row_that_is_not_finite_leaves_the_others_as_they_are(
    projector: Any, broken: float
) -> None:
    stack = normal(3, 4, 4)
    expected = resolved(weighted(projector=projector), stack)
    stack[1] = broken
    found = resolved(weighted(projector=projector), stack)
    torch.testing.assert_close(found[[0, 2]], expected[[0, 2]])
