"""Where a sum and a projection rest, and what each holds: see docs/research/projection.md.

A point moves against what a rule makes of the gradients of its goals.
"""

from collections.abc import Callable

import pytest
import torch
from _inputs import resolve, unweighted
from torch import Tensor

from aicon_torch import Resolution, Sum

Gradients = Callable[[Tensor], Tensor]
"""From points ``(*B, 2)`` to the gradients of their goals there, ``(*B, n, 2)``."""

STEP = 5e-3
MARGIN = 0.1
PROJECTION = unweighted(margin=MARGIN)
DOWN = torch.tensor([0.0, 1.0], dtype=torch.float64)  # the gradient of a pull downwards


def descend(rule: Resolution, gradients: Gradients, start: Tensor, steps: int) -> Tensor:
    """The way of points, ``(steps, *B, 2)``."""
    point, memory, way = start, None, []
    for _ in range(steps):
        resolved, memory = resolve(rule, gradients(point), memory)
        point = point - STEP * resolved
        way.append(point)
    return torch.stack(way)


def two_goals(point: Tensor) -> Tensor:
    """g₁ = ½‖x − (1, 0)‖² and g₂ = 2 √(1 + ‖x + (1, 0)‖²), which want the point elsewhere."""
    right, left = point - point.new_tensor([1.0, 0.0]), point + point.new_tensor([1.0, 0.0])
    pull = 2.0 * left / (1.0 + left.square().sum(-1, keepdim=True)).sqrt()
    return torch.stack((right, pull), dim=-2)


def test_with_two_goals_a_projection_rests_where_the_sum_does() -> None:
    starts = torch.tensor([[2.0, 0.5], [-1.5, 1.0], [0.3, -2.0]], dtype=torch.float64)

    by_sum = descend(Sum(), two_goals, starts, steps=1000)[-1]
    by_projection = descend(unweighted(margin=0.0), two_goals, starts, steps=1000)[-200:].mean(0)

    pulls = two_goals(by_sum)
    torch.testing.assert_close(pulls[:, 0], -pulls[:, 1], rtol=0.0, atol=2e-2)
    torch.testing.assert_close(by_projection, by_sum, rtol=0.0, atol=2e-2)


def floor_and_pulls(slope: float, pulls: Tensor) -> Gradients:
    """A floor at height 0 whose cost rises by a slope below it, and pulls ``(n, 2)`` everywhere."""

    def gradients(point: Tensor) -> Tensor:
        floor = -slope * DOWN * (point[1] < 0)
        return torch.cat((floor.unsqueeze(0), pulls))

    return gradients


def holds(rule: Resolution, slope: float, pulls: Tensor) -> bool:
    """Whether the floor lets the point through by no more than two steps of all together."""
    start = torch.tensor([0.0, 0.05], dtype=torch.float64)
    lowest = descend(rule, floor_and_pulls(slope, pulls), start, steps=120)[:, 1].min()
    return bool(lowest > -2 * STEP * (slope + pulls.norm(dim=-1).sum()))


@pytest.mark.parametrize("count", [1, 2, 3, 6])
def test_a_sum_holds_a_floor_that_is_steeper_than_all_pulls_together(count: int) -> None:
    pulls = DOWN.repeat(count, 1)

    assert holds(Sum(), 1.2 * count, pulls)
    assert not holds(Sum(), 0.8 * count, pulls)


@pytest.mark.parametrize("count", [1, 2, 3, 6])
def test_a_projection_holds_a_floor_that_is_steeper_than_the_largest(count: int) -> None:
    pulls = DOWN.repeat(count, 1)

    assert holds(PROJECTION, 1.2 * (1.0 + MARGIN), pulls)
    assert not holds(PROJECTION, 0.8 * (1.0 + MARGIN), pulls)


def test_pulls_that_lean_count_in_a_sum_by_their_cosine() -> None:
    cosine = 0.6
    left, right = [-0.8, cosine], [0.8, cosine]
    pulls = torch.tensor([left, right, left, right], dtype=torch.float64)

    assert holds(Sum(), 1.2 * 4 * cosine, pulls)
    assert not holds(Sum(), 0.8 * 4 * cosine, pulls)
    assert holds(PROJECTION, 1.2 * (1.0 + MARGIN), pulls)


def test_a_goal_that_is_met_protects_nothing() -> None:
    """Beside the floor, not above it, a pull goes where it wants: zero has no nullspace."""
    pull = torch.tensor([[0.3, 0.4]], dtype=torch.float64)
    above = torch.tensor([0.0, 1.0], dtype=torch.float64)

    resolved, _ = resolve(PROJECTION, floor_and_pulls(100.0, pull)(above))
    torch.testing.assert_close(resolved, pull[0])
