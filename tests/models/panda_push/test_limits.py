import pytest
import torch
from _inputs import normal
from _inputs.arm import panda, postures

from aicon_torch.models.panda_push import PANDA, MotionLimitOptions
from aicon_torch.models.panda_push.limits import ArmLimits, shorten
from aicon_torch.parts.contact import closest_point
from aicon_torch.parts.contact_dynamics import ContactDynamics
from aicon_torch.parts.contact_limits import ContactLimits
from aicon_torch.parts.rigid_object import RigidObject

SQUARE = RigidObject.of([(-0.1, -0.1), (0.1, -0.1), (0.1, 0.1), (-0.1, 0.1)])
DYNAMICS = ContactDynamics(SQUARE, rotation_length=0.1, step=1.0)
CONTACT = ContactLimits(
    DYNAMICS, radius=0.015, push=(0.001, 0.01), harm=0.002, slide_gap=0.0, end_step=0.005
)
OPTIONS = MotionLimitOptions()


def limited(a, q, contact=None, height=0.01, object_pose=(0.5, 0.0, 0.0)):
    """The velocity within the limits, and the motion of the end effector by it."""
    arm = panda(damping=1e-6)
    x_pusher = arm(q)[..., :2]
    x_obj = torch.tensor(object_pose, dtype=torch.float64).expand(*q.shape[:-1], 3)
    x_side = SQUARE.sides(SQUARE.keypoints_at(x_obj))
    x_contact = closest_point(x_pusher.unsqueeze(-2), x_side)
    x_target = x_obj + torch.tensor([0.05, 0.0, 0.0], dtype=torch.float64)
    x_heights = torch.full_like(q[..., :1], height)
    limits = ArmLimits(arm, PANDA.speed, OPTIONS, contact)
    kept = limits(a, q, x_pusher, x_contact, x_side, x_obj, x_target, x_heights)
    return kept, (arm.jacobian(q) @ kept.unsqueeze(-1)).squeeze(-1)


def test_slow_motions_are_left_alone():
    a, q = 1e-3 * normal(5, 7), postures(5)
    torch.testing.assert_close(limited(a, q)[0], a, rtol=1e-5, atol=1e-9)


def test_no_component_of_the_end_effector_is_faster_than_it_may_be():
    _, motion = limited(5.0 * normal(20, 7, seed=1), postures(20))
    bounds = OPTIONS.tip_speed * torch.tensor([1.0, 0.25, 0.25, 0.5], dtype=torch.float64)
    for part, bound in zip(torch.split(motion, [2, 1, 2, 1], dim=-1), bounds, strict=True):
        assert (part.norm(dim=-1) < 1.01 * bound).all()


def test_no_joint_is_faster_than_its_limit_and_the_direction_is_kept():
    null = torch.linalg.svd(panda().jacobian(postures(4)))[2][:, -1]  # moves the joints alone
    kept, _ = limited(10.0 * null, postures(4))
    assert (kept.abs() <= torch.tensor(PANDA.speed, dtype=torch.float64) + 1e-12).all()
    cosine = (kept * null).sum(-1) / kept.norm(dim=-1)
    torch.testing.assert_close(cosine, torch.ones_like(cosine))


@pytest.mark.parametrize(("height", "fastest"), [(0.004, 0.02), (0.2, 0.05)])
def test_the_tip_sinks_no_faster_than_it_would_arrive(height, fastest):
    q = postures(3)
    down = torch.tensor([0.0, 0.0, -0.3, 0.0, 0.0, 0.0], dtype=torch.float64).expand(3, 6)
    arm = panda(damping=1e-6)
    _, motion = limited(arm.solve(arm.jacobian(q), down), q, height=height)
    torch.testing.assert_close(motion[:, 2], torch.full((3,), -fastest, dtype=torch.float64))


def test_the_tip_keeps_the_limits_near_contact():
    arm, q = panda(damping=1e-6), postures(1)[0]
    tip = arm(q)[:2]
    behind = (float(tip[0]) + 0.115, float(tip[1]), 0.0)  # the square's near side is at the stick
    ahead = torch.tensor([0.2, 0.0, 0.0, 0.0, 0.0, 0.0], dtype=torch.float64)
    a = arm.solve(arm.jacobian(q), ahead)
    _, free = limited(a, q, object_pose=behind)
    _, kept = limited(a, q, contact=CONTACT, object_pose=behind)
    assert free[0] == pytest.approx(0.2, rel=1e-3)
    assert kept[0] == pytest.approx(0.01 / OPTIONS.horizon, rel=1e-3)


def test_long_vectors_are_shortened_and_short_ones_are_not():
    vectors = torch.tensor([[3.0, 4.0], [0.3, 0.4], [0.0, 0.0]])
    torch.testing.assert_close(shorten(vectors, 1.0).norm(dim=-1), torch.tensor([1.0, 0.5, 0.0]))
