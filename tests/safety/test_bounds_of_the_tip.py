"""A bound holds whatever gradient a part gives to goals: its slope is that of its gap."""

import torch
from _inputs import lean
from _inputs.reaching import planar_arm, reach
from torch import Tensor

from aicon_torch import Goal

WALL = 0.5
"""Where the tip must not go beyond along y, m."""

STARTS = torch.tensor([[-0.4, 0.6, 0.5], [-0.3, 1.2, 0.4], [0.8, -0.9, 0.3]], dtype=torch.float64)
TARGETS = torch.tensor([[0.2, 0.8, 0.0], [0.5, 0.7, 0.0], [-0.3, 0.75, 0.0]], dtype=torch.float64)


def beyond(x_ee: Tensor) -> Tensor:
    """How far the tip is behind the wall, m."""
    return x_ee[..., 1] - WALL


def test_the_tip_stays_before_a_wall_by_its_natural_gradient() -> None:
    robot = planar_arm(shape=False)
    policy = lean("reach", robot=robot).with_goal(Goal("wall", beyond, safety=True))
    assert policy.model.owners["x_ee"].relation.function.pullback == "natural"

    way, _ = reach(policy, STARTS, seconds=3, target_position=TARGETS)
    places = robot.chain(way)[..., 1, 3]
    assert places.max() < WALL + 2e-4
    assert (places.max(dim=0).values > WALL - 0.02).all()  # each of them comes to the wall
