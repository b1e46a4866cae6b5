import torch
from _inputs.arm import panda, postures, tool_pose

from aicon_torch.parts.rigid_object import RigidObject
from aicon_torch.parts.touch import ContactForce, ForceThreshold, TouchedSide, TouchedTop

SQUARE = RigidObject.of([(-0.1, -0.1), (0.1, -0.1), (0.1, 0.1), (-0.1, 0.1)])
PUSH = ForceThreshold(force=1.0, width=0.1)
SIDE = TouchedSide(SQUARE, radius=0.02, deviation=0.01, push=PUSH)


def vector(*numbers):
    return torch.tensor(numbers, dtype=torch.float64, requires_grad=True)


def test_a_tool_that_touches_nothing_feels_nothing_in_any_posture():
    arm = panda()
    x_ee = arm(postures(5))
    rotation, _ = tool_pose().to_frame(x_ee)
    holding = (rotation.mT @ torch.tensor([0.0, 0.0, 0.25 * 9.81], dtype=torch.float64)).squeeze(-1)
    z_ft = torch.cat((holding, torch.zeros(5, 3)), dim=-1)
    felt = ContactForce(tool_pose(), mass=0.25)(z_ft, x_ee)
    torch.testing.assert_close(felt, torch.zeros(5, 3, dtype=torch.float64))


def test_a_force_is_felt_in_the_frame_of_the_base():
    x_ee = panda()(postures(3))
    rotation, _ = tool_pose().to_frame(x_ee)
    push = torch.tensor([2.0, -1.0, 0.5], dtype=torch.float64)
    weight = torch.tensor([0.0, 0.0, -0.25 * 9.81], dtype=torch.float64)
    reading = -(rotation.mT @ (push + weight).unsqueeze(-1)).squeeze(-1)
    z_ft = torch.cat((reading, torch.zeros(3, 3)), dim=-1)
    felt = ContactForce(tool_pose(), mass=0.25)(z_ft, x_ee)
    torch.testing.assert_close(felt, push.expand(3, 3))


def test_a_force_at_the_threshold_is_a_push_as_likely_as_not():
    likelihood = PUSH(torch.tensor([0.0, 1.0, 2.0]))
    assert likelihood[0] < 1e-4 and likelihood[1] == 0.5 and likelihood[2] > 1 - 1e-4


def test_the_gap_is_that_to_the_nearest_side():
    gap = SIDE(vector(0.0, 0.0, 0.0), vector(0.15, 0.05))
    torch.testing.assert_close(gap, torch.tensor([0.03], dtype=torch.float64))


def test_the_object_follows_from_a_touch_and_the_tool_does_not():
    pose, pusher = vector(0.0, 0.0, 0.0), vector(0.15, 0.05)
    slopes = torch.autograd.grad(SIDE(pose, pusher).sum(), (pose, pusher), allow_unused=True)
    torch.testing.assert_close(slopes[0][:2].tolist(), [-1.0, 0.0])
    assert slopes[1] is None


def test_without_a_force_the_gap_means_nothing():
    variance = [float(SIDE.variance(vector(force, 0.0, 5.0))) for force in (0.0, 1.0, 3.0)]
    assert variance[0] > 1e3 and variance[1] == 4 * 1e-4 and abs(variance[2] - 1e-4) < 1e-9


def test_what_is_certainly_no_push_has_a_variance_that_is_a_number_in_single_precision():
    push = ForceThreshold(force=20.0, width=0.02)
    side, top = TouchedSide(SQUARE, 0.02, 0.001, push), TouchedTop(0.001, PUSH)
    for variance in (side.variance(torch.zeros(3)), top.variance(torch.tensor([0.0, 0.0, -50.0]))):
        assert variance.isfinite() and variance > 1e6


def test_a_tool_that_is_pushed_up_stands_on_what_is_below_it():
    top = TouchedTop(deviation=0.003, push=PUSH)
    x_ee = vector(0.5, 0.0, 0.035, 0.0, 0.0, 0.0)
    residual = top(vector(0.04), x_ee)
    torch.testing.assert_close(residual, torch.tensor([0.005], dtype=torch.float64))
    slopes = (
        torch.autograd.grad(residual.sum(), (x_ee,), allow_unused=True)
        if residual.grad_fn
        else None
    )
    assert slopes == (None,)
    up, aside = (float(top.variance(vector(*force))) for force in ((0, 0, 3.0), (3.0, 0, 0)))
    assert abs(up - 9e-6) < 1e-9 and aside > 1
