"""What the arm wants of the object."""

import pytest
import torch

from aicon_torch.models.arm_push import PANDA
from aicon_torch.models.arm_push.goals import PushWithinReach, Ring
from aicon_torch.parts import PoseDistance, RigidObject, SquaredHinge

RING = Ring((0.45, 0.65), SquaredHinge(margin=0.03, weight=0.045))
TARGET = torch.tensor([0.5, 0.0, 0.0])


def test_the_ring_of_an_object_is_as_wide_as_the_stick_gets_around_it() -> None:
    square = RigidObject.of([(-0.1, -0.1), (0.1, -0.1), (0.1, 0.1), (-0.1, 0.1)])
    around = 0.1 * 2**0.5 + PANDA.stick_radius
    edges = Ring.within_reach(PANDA, square, RING.cost).edges
    assert edges == pytest.approx((PANDA.nearest + around, PANDA.reach - around))


@pytest.mark.parametrize(("x", "slope"), [(0.46, -1.0), (0.55, 0.0), (0.64, 1.0)])
def test_an_object_is_kept_where_the_tip_gets_behind_it(x: float, slope: float) -> None:
    pose = torch.tensor([x, 0.0, 0.3], requires_grad=True)
    cost = RING(pose)
    (gradient,) = torch.autograd.grad(cost, pose)
    assert (cost > 0) == (slope != 0) and gradient[0].sign() == slope
    assert not gradient[1:].any()


def test_within_the_ring_only_the_target_counts() -> None:
    pose = torch.tensor([0.55, 0.05, 0.3])
    pushed, plain = PushWithinReach(0.04, RING), PoseDistance(0.04)
    assert pushed(pose, TARGET) == plain(pose, TARGET)
