"""What the arm wants of the object."""

import pytest
import torch

from aicon_torch.models.panda_push.goals import PushWithinReach, Ring
from aicon_torch.parts import PoseDistance, SquaredHinge

RING = Ring((0.45, 0.65), SquaredHinge(margin=0.03, weight=0.045))
TARGET = torch.tensor([0.5, 0.0, 0.0])


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
