import pytest
import torch
from _inputs import normal
from _inputs.arm import panda, postures

from aicon_torch.models.arm_push import PANDA
from aicon_torch.models.arm_push.limits import TIP_SPEED, ArmLimits, shorten


def limited(a, q, height=0.01):
    """The velocity within the limits, and the motion of the end effector by it."""
    arm = panda(damping=1e-6)
    limits = ArmLimits(arm, PANDA.chain.speed.tolist())
    kept = limits(a, q, torch.full_like(q[..., :1], height))
    return kept, (arm.jacobian(q) @ kept.unsqueeze(-1)).squeeze(-1)


def test_slow_motions_are_left_alone():
    a, q = 1e-3 * normal(5, 7), postures(5)
    torch.testing.assert_close(limited(a, q)[0], a, rtol=1e-5, atol=1e-9)


def test_no_component_of_the_end_effector_is_faster_than_it_may_be():
    _, motion = limited(5.0 * normal(20, 7, seed=1), postures(20))
    bounds = TIP_SPEED * torch.tensor([1.0, 0.25, 0.25, 0.5], dtype=torch.float64)
    for part, bound in zip(torch.split(motion, [2, 1, 2, 1], dim=-1), bounds, strict=True):
        assert (part.norm(dim=-1) < 1.01 * bound).all()


def test_no_joint_is_faster_than_its_limit_and_the_direction_is_kept():
    null = torch.linalg.svd(panda().jacobian(postures(4)))[2][:, -1]  # moves the joints alone
    kept, _ = limited(10.0 * null, postures(4))
    assert (kept.abs() <= PANDA.chain.speed + 1e-12).all()
    cosine = (kept * null).sum(-1) / kept.norm(dim=-1)
    torch.testing.assert_close(cosine, torch.ones_like(cosine))


@pytest.mark.parametrize(("height", "fastest"), [(0.004, 0.02), (0.2, TIP_SPEED / 4)])
def test_the_tip_sinks_no_faster_than_it_would_arrive(height, fastest):
    q = postures(3)
    down = torch.tensor([0.0, 0.0, -0.3, 0.0, 0.0, 0.0], dtype=torch.float64).expand(3, 6)
    arm = panda(damping=1e-6)
    _, motion = limited(arm.solve(arm.jacobian(q), down), q, height=height)
    torch.testing.assert_close(motion[:, 2], torch.full((3,), -fastest, dtype=torch.float64))


def test_long_vectors_are_shortened_and_short_ones_are_not():
    vectors = torch.tensor([[3.0, 4.0], [0.3, 0.4], [0.0, 0.0]])
    torch.testing.assert_close(shorten(vectors, 1.0).norm(dim=-1), torch.tensor([1.0, 0.5, 0.0]))
