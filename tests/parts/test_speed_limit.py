import torch
from _inputs import normal
from _inputs.arm import panda_chain, postures

from aicon_torch.parts.end_effector import EndEffector
from aicon_torch.parts.speed_limit import SpeedLimit
from aicon_torch.parts.tip_pose import TipPose

ARM = EndEffector(panda_chain(), TipPose("full"))


def test_the_tip_is_never_faster_and_keeps_its_direction() -> None:
    q, a = postures(20), 5 * normal(20, 7, seed=1)
    limited = SpeedLimit(ARM, speed=0.25)(a, q)
    speed = (ARM.jacobian(q)[:, :3] @ limited.unsqueeze(-1)).squeeze(-1).norm(dim=-1)
    assert (speed <= 0.25 + 1e-9).all()
    torch.testing.assert_close(
        limited / limited.norm(dim=-1, keepdim=True), a / a.norm(dim=-1, keepdim=True)
    )


def test_a_slow_tip_moves_as_it_is_wished_for() -> None:
    q, a = postures(5), 1e-3 * normal(5, 7, seed=1)
    assert (SpeedLimit(ARM, speed=0.25)(a, q) == a).all()
