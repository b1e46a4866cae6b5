import pytest
import torch
from _inputs import normal
from _inputs.arm import panda_chain, postures

from aicon_torch.errors import OptionError
from aicon_torch.parts.end_effector import EndEffector
from aicon_torch.parts.pose_reach import PoseReach
from aicon_torch.parts.tip_metric import TipMetric
from aicon_torch.parts.tip_pose import TipPose

ARM = EndEffector(panda_chain(), TipPose("full"), damping=0.15)


def test_a_departure_counts_by_how_far_it_takes_the_tip_and_the_joints() -> None:
    q, departure = postures(5), normal(5, 7, seed=1)
    of_tip = (ARM.jacobian(q) @ departure.unsqueeze(-1)).squeeze(-1)
    weighed = (TipMetric(ARM)(q) @ departure.unsqueeze(-1)).squeeze(-1)
    expected = (of_tip * of_tip).sum(-1) + 0.15**2 * (departure * departure).sum(-1)
    torch.testing.assert_close((departure * weighed).sum(-1), expected)


def test_a_wish_is_the_damped_solution_of_the_same_metric() -> None:
    """M J⁺h = Jᵀh."""
    q, gradient = postures(5), normal(5, 12, seed=1)
    jacobian = ARM.jacobian(q)
    nominal = ARM.solve(jacobian, gradient).unsqueeze(-1)
    torch.testing.assert_close(TipMetric(ARM)(q) @ nominal, jacobian.mT @ gradient.unsqueeze(-1))


WAITING = EndEffector(panda_chain(), TipPose("full"), damping=0.15, turns_within=0.2)


def test_turns_wait_until_the_place_is_near() -> None:
    """w is 1 there, 1/2 at the distance r, and falls with its square; places always count one."""
    x_ee = torch.zeros(4, 12, dtype=torch.float64)
    target = x_ee.clone()
    target[:, 0] = torch.tensor([0.0, 0.2, 0.6, 2.0])
    weights = WAITING.weights(x_ee, target)
    assert weights is not None
    assert (weights[:, :3] == 1).all()
    of_turns = torch.tensor([1.0, 1 / 2, 1 / 10, 1 / 101], dtype=torch.float64)
    torch.testing.assert_close(weights[:, 3:], of_turns.unsqueeze(-1).expand(-1, 9))


def test_the_gradient_and_the_metric_weigh_turns_alike() -> None:
    """M a = Jᵀ W² h, for the motion a along the gradient of a goal."""
    q, target = postures(5), WAITING(postures(6)[1:])
    jacobian, x_ee = WAITING.jacobian(q), WAITING(q)
    weights = WAITING.weights(x_ee, target)
    assert weights is not None

    at_joints = q.requires_grad_()
    cost = PoseReach(TipPose("full"))(WAITING(at_joints, target), target)
    (slope,) = torch.autograd.grad(cost.sum(), at_joints)
    weighed = (TipMetric(WAITING)(q.detach(), target) @ slope.unsqueeze(-1)).squeeze(-1)

    at_tip = x_ee.requires_grad_()
    (wish,) = torch.autograd.grad(PoseReach(TipPose("full"))(at_tip, target).sum(), at_tip)
    expected = (jacobian.mT @ (weights**2 * wish).unsqueeze(-1)).squeeze(-1)
    aligned = torch.nn.functional.cosine_similarity(weighed, expected)
    torch.testing.assert_close(aligned, torch.ones(5, dtype=torch.float64))


def test_turns_wait_within_a_distance() -> None:
    with pytest.raises(OptionError, match="turns_within=0: expected a distance > 0"):
        EndEffector(panda_chain(), TipPose("full"), turns_within=0)
