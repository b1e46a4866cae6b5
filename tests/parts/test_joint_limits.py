import pytest
import torch

from aicon_torch.errors import OptionError
from aicon_torch.parts.hinge import SquaredHinge
from aicon_torch.parts.joint_limits import JointLimits

GOAL = JointLimits(low=(-1.0, -2.0), high=(1.0, 3.0), cost=SquaredHinge(margin=0.1, weight=0.5))


def joints(*angles):
    return torch.tensor(angles, dtype=torch.float64, requires_grad=True)


def test_joints_far_from_their_limits_are_free():
    assert GOAL(joints(0.89, 2.89)) == 0 and GOAL(joints(-0.89, -1.89)) == 0


def test_near_a_limit_the_cost_falls_as_the_joint_turns_back():
    for q, sign in ((joints(0.95, 0.0), 1.0), (joints(-0.95, 0.0), -1.0)):
        (slope,) = torch.autograd.grad(GOAL(q), q)
        assert slope[0] * sign > 0 and slope[1] == 0


def test_the_cost_of_several_joints_adds_up():
    torch.testing.assert_close(
        GOAL(joints(1.0, 2.95)), torch.tensor(0.5 + 0.125, dtype=torch.float64)
    )


def test_the_room_is_how_far_a_joint_may_turn_either_way():
    down, up = GOAL.room(joints(0.5, -1.0).detach())
    torch.testing.assert_close(down, torch.tensor([1.4, 0.9], dtype=torch.float64))
    torch.testing.assert_close(up, torch.tensor([0.4, 3.9], dtype=torch.float64))


@pytest.mark.parametrize(
    ("low", "high"),
    [((float("nan"),), (1.0,)), ((1.0,), (-1.0,)), ((0.0,), (float("nan"),)), ((0.0, 1.0), (2.0,))],
)
def test_limits_that_are_none_are_errors(low, high):
    with pytest.raises(OptionError, match="expected a limit of each joint, the lower one below"):
        JointLimits(low, high, GOAL.cost)
