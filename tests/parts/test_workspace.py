import math

import pytest
import torch
from _inputs.arm import panda

from aicon_torch.models.arm_push import PANDA
from aicon_torch.parts.chain import Chain
from aicon_torch.parts.hinge import SquaredHinge
from aicon_torch.parts.workspace import Workspace


def test_the_cost_begins_at_the_margin_and_is_the_same_in_all_directions():
    cost = Workspace(radius=0.8, cost=SquaredHinge(margin=0.1, weight=2.0))
    x_ee = 0.75 * torch.tensor([[1.0, 0.0], [0.6, -0.8], [0.9, 0.0]], dtype=torch.float64)
    torch.testing.assert_close(cost(x_ee), torch.tensor([0.5, 0.5, 0.0], dtype=torch.float64))


def test_on_the_axis_of_the_base_it_has_a_derivative():
    x_ee = torch.zeros(6, dtype=torch.float64, requires_grad=True)
    (slope,) = torch.autograd.grad(Workspace(0.8, SquaredHinge(0.1, 2.0))(x_ee), x_ee)
    assert (slope == 0).all()


def test_the_workspace_ends_where_the_arm_is_straight():
    arm = panda()
    straight = -math.atan(0.0825 / 0.316) - math.atan(0.0825 / 0.384)
    q = torch.tensor([0.0, 1.2, 0.0, straight, 0.0, 1.7, 0.0], dtype=torch.float64)
    goal = torch.tensor([0.02, 0.0], dtype=torch.float64)  # height of the tip, and no tilt
    for _ in range(20):
        reached = arm(q)[2:4]
        jacobian = arm.jacobian(q)[2:4][:, [1, 5]]
        q[[1, 5]] += torch.linalg.solve(jacobian, goal - reached)

    x_ee = arm(q)
    torch.testing.assert_close(x_ee[2:4], goal)
    assert x_ee[:2].norm() == pytest.approx(PANDA.reach, abs=1e-3)
    assert torch.linalg.svdvals(arm.jacobian(q))[-1] < 1e-3

    cost = Workspace(PANDA.reach, SquaredHinge(margin=0.02, weight=15.0))
    assert cost(x_ee) > 14 and cost(0.97 * x_ee) == 0


def test_an_arm_of_two_links_reaches_as_far_as_both_are_long() -> None:
    link = [[1.0, 0.0, 0.0, 0.3], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]
    workspace = Workspace.of_chain(Chain([link, link], link), SquaredHinge(0.05, 1.0))
    assert workspace.radius == pytest.approx(0.9, abs=0.005)

    tip = torch.tensor([0.0, 0.5, 0.2])
    assert workspace.gaps(tip) == pytest.approx(workspace.radius - 0.55, abs=1e-5)
