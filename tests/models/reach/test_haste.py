"""In haste a joint at its limit holds nothing back that the tip gains by."""

import pytest
import torch
from _inputs import quick
from _inputs.reaching import DT, planar_arm, reach
from torch import Tensor

from aicon_torch import OptionError, make_policy

START = torch.tensor([0.1, 0.4, -0.3], dtype=torch.float64)
TARGETS = torch.tensor([(-0.2, 0.6, 0.0), (0.3, -0.5, 0.0), (0.55, 0.35, 0.0)], dtype=torch.float64)


def ways(haste: float) -> Tensor:
    """The ways of the joints to the targets, ``(steps, targets, 3)``."""
    policy = quick(make_policy("reach", robot=planar_arm(), **{"dampers.haste": haste}))
    way, _ = reach(policy, START.expand(3, -1), 2.0, target_position=TARGETS)
    return way


def test_it_arrives_no_later_and_no_joint_is_faster_than_it_may_be() -> None:
    calm, hasty = ways(1.0), ways(2.0)
    steps = []
    for way in (calm, hasty):
        missing = (planar_arm().chain(way)[..., :3, 3] - TARGETS).norm(dim=-1)
        assert (missing[-1] < 0.01).all()
        steps.append((missing >= 0.01).sum(0))
    assert (steps[1] <= steps[0]).all()
    assert (steps[1] < steps[0]).any()
    assert (hasty.diff(dim=0).abs() <= 1.5 * DT + 1e-9).all()


def test_without_haste_it_is_refused() -> None:
    with pytest.raises(OptionError, match="haste=0"):
        make_policy("reach", robot=planar_arm(), **{"dampers.haste": 0.0})
