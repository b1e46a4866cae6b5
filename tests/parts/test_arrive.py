import torch
from _inputs import normal
from _inputs.arm import panda_chain, postures

from aicon_torch.parts.arrive import Arrive
from aicon_torch.parts.end_effector import EndEffector
from aicon_torch.parts.tip_pose import TipPose

ARM = EndEffector(panda_chain(), TipPose("free"), damping=1e-6)
TIME = 0.2


def test_far_from_the_target_the_action_stays_as_it_is() -> None:
    q, a = postures(5), normal(5, 7, seed=1)
    x_ee = ARM(q)
    target = x_ee + 100 * (ARM.jacobian(q) @ a.unsqueeze(-1)).squeeze(-1)
    assert (Arrive(ARM, TIME)(a, q, x_ee, target) == a).all()


def test_near_the_target_it_is_approached_exponentially() -> None:
    q, a = postures(5), normal(5, 7, seed=1)
    x_ee, velocity = ARM(q), (ARM.jacobian(q) @ a.unsqueeze(-1)).squeeze(-1)
    target = x_ee + 0.05 * velocity
    shortened = Arrive(ARM, TIME)(a, q, x_ee, target)
    torch.testing.assert_close(shortened, a * 0.05 / TIME)


def test_away_from_the_target_it_may_go() -> None:
    q, a = postures(5), normal(5, 7, seed=1)
    x_ee = ARM(q)
    target = x_ee - 0.01 * (ARM.jacobian(q) @ a.unsqueeze(-1)).squeeze(-1)
    assert (Arrive(ARM, TIME)(a, q, x_ee, target) == a).all()


def test_an_arm_at_rest_at_its_target_rests() -> None:
    q = postures(1)[0]
    rest = torch.zeros(7, dtype=torch.float64)
    assert (Arrive(ARM, TIME)(rest, q, ARM(q), ARM(q)) == 0).all()
