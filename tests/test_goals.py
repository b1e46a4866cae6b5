"""Goals: costs with a tolerance, and the gaps of those that nothing may violate."""

import pytest
import torch
from torch import Tensor

from aicon_torch import Goal, GraphError
from aicon_torch.parts import JointLimits, SquaredHinge


def distance(x: Tensor) -> Tensor:
    return x.norm(dim=-1)


def test_a_cost_counts_from_the_tolerance_on() -> None:
    goal = Goal("reach", distance, tolerance=0.5)
    x = torch.tensor([[0.3, 0.0], [2.0, 0.0]], requires_grad=True)
    cost = goal({"x": x})
    torch.testing.assert_close(cost, torch.tensor([0.0, 1.5]))

    (slope,) = torch.autograd.grad(cost.sum(), x)
    torch.testing.assert_close(slope, torch.tensor([[0.0, 0.0], [1.0, 0.0]]))


def test_the_gap_of_a_cost_is_what_is_left_of_its_tolerance() -> None:
    goal = Goal("stay", distance, tolerance=0.5, safety=True)
    gaps = goal.gaps({"x": torch.tensor([[0.3, 0.0], [2.0, 0.0]])})
    torch.testing.assert_close(gaps, torch.tensor([[0.2], [-1.5]]))


def test_a_part_that_knows_its_gaps_says_them() -> None:
    stops = JointLimits((-1.0, -2.0), (1.0, 2.0), SquaredHinge(margin=0.1, weight=1.0))
    goal = Goal("stops", stops, safety=True)
    values = {"x_joints": torch.tensor([0.7, -1.95])}
    torch.testing.assert_close(goal.gaps(values), torch.tensor([1.6, -0.05, 0.2, 3.85]))
    assert goal(values) > 0


def test_a_tolerance_below_zero_is_refused() -> None:
    with pytest.raises(GraphError, match="Goal 'reach': tolerance=-1; expected a number >= 0"):
        Goal("reach", distance, tolerance=-1)
