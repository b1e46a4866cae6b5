import pytest
import torch
from _inputs import normal
from _inputs.arm import HOME, panda, postures, tool_pose
from torch.nn.functional import normalize

from aicon_torch import NullspaceProjection
from aicon_torch.parts.chain import Chain, Joint
from aicon_torch.parts.end_effector import EndEffector


def test_the_jacobian_is_the_derivative_of_the_end_effector():
    plain, q = panda("transpose"), postures(5)
    expected = torch.autograd.functional.jacobian(lambda x: plain(x).sum(0), q).permute(1, 0, 2)
    torch.testing.assert_close(plain.jacobian(q), expected)


def test_the_jacobian_is_that_of_a_joint_about_another_axis_and_of_one_that_slides():
    fixed = [torch.eye(4).tolist()] * 3
    joints = [Joint("lift", slides=True), Joint("roll", (1.0, 0.0, 0.0)), Joint("turn")]
    arm = EndEffector(Chain(fixed, fixed[0], joints), tool_pose(), "transpose")

    q = normal(4, 3, seed=1)
    expected = torch.autograd.functional.jacobian(lambda x: arm(x).sum(0), q).permute(1, 0, 2)
    torch.testing.assert_close(arm.jacobian(q), expected)


def test_the_end_effector_tells_where_the_tool_is():
    arm = panda()
    frames = arm.chain.frames(postures(6))
    rotation, origin = tool_pose().to_frame(arm.at(frames))
    torch.testing.assert_close(rotation, frames[:, 7, :3, :3])
    torch.testing.assert_close(origin, frames[:, 7, :3, 3])


def test_the_pullback_does_not_change_the_value():
    q = postures(3)
    values = [panda(pullback)(q.clone().requires_grad_()) for pullback in ("natural", "transpose")]
    torch.testing.assert_close(values[0], values[1], rtol=0, atol=0)
    torch.testing.assert_close(values[0], panda()(q), rtol=0, atol=0)


def test_the_transpose_is_the_chain_rule():
    arm, q, wish = panda("transpose"), postures(4).requires_grad_(), normal(4, 6, seed=1)
    (found,) = torch.autograd.grad(arm(q), q, wish)
    expected = (arm.jacobian(q.detach()).mT @ wish.unsqueeze(-1)).squeeze(-1)
    torch.testing.assert_close(found, expected)


def test_the_natural_pullback_moves_along_the_gradient_and_is_as_long_as_its_cost_falls():
    arm = panda(damping=1e-6)
    q, wish = postures(4).requires_grad_(), normal(4, 6, seed=1)
    (step,) = torch.autograd.grad(arm(q), q, wish)
    moved = (arm.jacobian(q.detach()) @ step.unsqueeze(-1)).squeeze(-1)
    directions = normalize(moved, dim=-1), normalize(wish, dim=-1)
    torch.testing.assert_close(*directions, rtol=1e-4, atol=1e-6)

    length = step.norm(dim=-1)
    change_per_rad = (wish * moved).sum(-1) / length  # h·J u for the unit u of the step
    torch.testing.assert_close(change_per_rad, length)


def test_a_gradient_of_zero_stays_zero():
    q = HOME.clone().requires_grad_()
    (step,) = torch.autograd.grad(panda()(q), q, torch.zeros(6, dtype=torch.float64))
    assert (step == 0).all()


def test_near_a_singularity_the_end_effector_does_not_outgrow_what_it_meets():
    arm, q = panda(), HOME.clone()
    q[[0, 2, 4]], q[3], q[5] = 0.0, -0.467, 1.66
    jacobian = arm.jacobian(q)
    assert torch.linalg.svdvals(jacobian)[-1] < 0.01

    outward = torch.tensor([1.0, 0.0, 0.0, 0.0, 0.0, 0.0], dtype=torch.float64)
    shortened = arm.natural_gradient(jacobian, outward)
    assert arm.solve(jacobian, outward).norm() > 1 > shortened.norm()


@pytest.mark.parametrize(("pullback", "stays"), [("natural", True), ("transpose", False)])
def test_what_was_settled_at_the_end_effector_stays_so_with_the_natural_pullback(pullback, stays):
    """The sum of projected gradients never raises the leader's cost, whatever the arm's posture."""
    draws, count = 500, 4
    jacobian = panda().jacobian(HOME + 0.3 * normal(draws, 7, seed=2))
    gradients = normal(draws, count, 6, seed=3)
    rule = NullspaceProjection(exploration=None)
    _, directions, weights = rule.normalize(gradients)
    projected, rank = rule.project_in_order(
        directions * weights.unsqueeze(-1), weights, held=torch.full((draws, count), -1)
    )
    resolved, leader = projected.sum(-2), gradients[torch.arange(draws), rank[:, 0]]

    if pullback == "natural":
        step = panda().natural_gradient(jacobian, resolved)
    else:
        step = (jacobian.mT @ resolved.unsqueeze(-1)).squeeze(-1)
    motion = -(jacobian @ step.unsqueeze(-1)).squeeze(-1)
    rises = (leader * motion).sum(-1) > 1e-9
    assert (not rises.any()) == stays


def test_a_wrong_pullback_is_named():
    arm = panda()
    with pytest.raises(ValueError, match="pullback='inverse': expected one of 'natural'"):
        EndEffector(arm.chain, arm.pose, "inverse")
