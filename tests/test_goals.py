"""Goals: costs with a tolerance, and the gaps of those that nothing may violate."""

from pathlib import Path

import pytest
import torch
from _inputs.tracking import near, tracking_model
from torch import Tensor

from aicon_torch import Actuator, DirectDescent, Goal, GraphError, Policy, Sum
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


def at_best_half(p: Tensor) -> Tensor:
    """A cost that branches, which torch does not allow of what is compiled."""
    return near(p) if near(p).max() > 0.5 else 0.5 * near(p)


def test_a_cost_that_branches_is_named_where_it_is_compiled(tmp_path: Path) -> None:
    actuators = {"a": Actuator(2, "m/s", limit=1.0)}
    model = tracking_model(goals=[Goal("half", at_best_half)], actuators=actuators)
    policy = Policy(model, Sum(), DirectDescent())
    policy.predict({"z": torch.ones(2)})
    with pytest.raises(GraphError, match=r"Goal 'half': .*at_best_half.* torch\.where"):
        policy.export(tmp_path / "half.c")
