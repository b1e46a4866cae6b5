"""The motion of an object that is pushed, and the distance to its target."""

import math

import pytest
import torch
from _inputs.pushing import RADIUS, body_of, from_pixels, poses
from torch import Tensor

from aicon_torch.models.pusht.benchmark import PIXEL, T_WIDTH
from aicon_torch.parts import (
    ContactOptions,
    FixedTarget,
    PoseDistance,
    PoseMotion,
    RigidObject,
    pose_jacobian,
    resting_pose,
)

SQUARE = RigidObject.of(from_pixels((-30, -30), (30, -30), (30, 30), (-30, 30)))
MOTION = PoseMotion(ContactOptions(size=T_WIDTH).dynamics(SQUARE), RADIUS)
BESIDE = -30 - RADIUS / PIXEL
"""Where the pusher touches the left side of the square, px."""


def pushed(start: tuple[float, float], velocity: tuple[float, float]) -> Tensor:
    """The pose of a square at the origin after a pusher has moved from a place, px, for 0.1 s."""
    a = PIXEL * torch.tensor(velocity, dtype=torch.float64)
    arrived = PIXEL * torch.tensor(start, dtype=torch.float64) + 0.1 * a
    return MOTION(torch.zeros(3, dtype=torch.float64), arrived, a, 0.1)


def test_an_object_is_pushed_as_far_as_the_pusher_goes_beyond_the_gap() -> None:
    """Head on, 5 px before the side: of 20 px the object gets 15."""
    moved = pushed((BESIDE - 5, 0), (200, 0))
    expected = torch.tensor([15 * PIXEL, 0.0, 0.0], dtype=torch.float64)
    torch.testing.assert_close(moved, expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("velocity", [(40, 0), (-500, 0), (0, 500)])
def test_nothing_moves_what_is_not_reached(velocity: tuple[float, float]) -> None:
    moved = pushed((BESIDE - 5, 0), velocity)
    assert moved.tolist() == [0.0, 0.0, 0.0]


def test_a_push_beside_the_centre_turns_the_object() -> None:
    above = pushed((BESIDE, 20), (100, 0))
    below = pushed((BESIDE, -20), (100, 0))
    assert float(above[2]) < 0 < float(below[2])
    torch.testing.assert_close(above[:1], below[:1])


def test_the_belief_moves_as_it_is_and_leads_no_gradient_to_the_push() -> None:
    pose = poses(1)[0].requires_grad_()
    pusher, a = (torch.ones(2, dtype=torch.float64, requires_grad=True) for _ in range(2))
    moved = PoseMotion(ContactOptions(size=T_WIDTH).dynamics(body_of()), RADIUS)(
        pose, pusher, a, 0.1
    )

    jacobian = torch.stack([torch.autograd.grad(x, pose, retain_graph=True)[0] for x in moved])
    torch.testing.assert_close(jacobian, pose_jacobian(pusher))
    assert not torch.autograd.grad(moved.sum(), (pusher, a), allow_unused=True)[0]


def test_a_pose_at_rest_is_the_same() -> None:
    pose = poses(3)
    assert torch.equal(resting_pose(pose), pose)


def test_the_distance_counts_a_rotation_as_a_length_the_shorter_way_round() -> None:
    """√(|Δc|² + (Lθ)²)."""
    pose, target = poses(50, seed=1), poses(50, seed=2)
    turn = pose[:, 2] - target[:, 2]
    turn = torch.atan2(turn.sin(), turn.cos())
    squares = (pose[:, :2] - target[:, :2]).square().sum(-1) + (0.08 * turn) ** 2
    torch.testing.assert_close(PoseDistance(0.08)(pose, target), squares.sqrt())


def test_a_fixed_target_is_that_of_every_row() -> None:
    target = FixedTarget(torch.tensor([0.1, 0.2, math.pi], dtype=torch.float64))
    pose = poses(4)
    assert torch.equal(target(pose), target.pose.expand(4, 3))
    assert target(pose.float()).dtype == torch.float32
