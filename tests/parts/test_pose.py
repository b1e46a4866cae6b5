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
    resting_pose,
)

SQUARE = RigidObject.of(from_pixels((-30, -30), (30, -30), (30, 30), (-30, 30)))
MOTION = PoseMotion(ContactOptions(size=T_WIDTH).dynamics(SQUARE), RADIUS)
BESIDE = -30 - RADIUS / PIXEL
"""Where the pusher touches the left side of the square, px."""


def pushed(start: tuple[float, float], *places: tuple[float, float]) -> Tensor:
    """The pose of a square at the origin after a pusher has gone from a place, px, by a way."""
    way = PIXEL * torch.tensor(places, dtype=torch.float64)
    arrived = PIXEL * torch.tensor(start, dtype=torch.float64) + way[-1]
    return MOTION(torch.zeros(3, dtype=torch.float64), arrived, way.flatten())


def test_an_object_is_pushed_as_far_as_the_pusher_goes_beyond_the_gap() -> None:
    """Head on, 5 px before the side: of 20 px the object gets 15."""
    moved = pushed((BESIDE - 5, 0), (20, 0))
    expected = torch.tensor([15 * PIXEL, 0.0, 0.0], dtype=torch.float64)
    torch.testing.assert_close(moved, expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("way", [(4, 0), (-50, 0), (0, 50)])
def test_nothing_moves_what_is_not_reached(way: tuple[float, float]) -> None:
    moved = pushed((BESIDE - 5, 0), way)
    assert moved.tolist() == [0.0, 0.0, 0.0]


def test_a_push_beside_the_centre_turns_the_object() -> None:
    above = pushed((BESIDE, 20), (10, 0))
    below = pushed((BESIDE, -20), (10, 0))
    assert float(above[2]) < 0 < float(below[2])
    torch.testing.assert_close(above[:1], below[:1])


# --- the way, part by part


def test_a_way_straight_on_pushes_as_far_in_parts_as_at_once() -> None:
    at_once = pushed((BESIDE - 5, 0), (20, 0))
    in_parts = pushed((BESIDE - 5, 0), (3, 0), (12, 0), (20, 0))
    torch.testing.assert_close(in_parts, at_once, rtol=0, atol=1e-12)


def test_an_object_stays_where_the_pusher_has_left_it() -> None:
    """A pusher that goes beyond where it arrives has pushed as far as it went."""
    there, back = pushed((BESIDE, 0), (9, 0)), pushed((BESIDE, 0), (9, 0), (2, 0))
    assert float(there[0]) == pytest.approx(9 * PIXEL)
    torch.testing.assert_close(back, there)


def test_a_way_round_a_corner_pushes_nothing_though_the_straight_one_would() -> None:
    down = [(0.0, -10.0 * part) for part in range(1, 8)]
    across = [(10.0 * part, -70.0) for part in range(1, 11)]
    up = [(100.0, -70.0 + 10.0 * part) for part in range(1, 8)]

    start = (BESIDE - 5, 0)
    assert pushed(start, *down, *across, *up).tolist() == [0.0, 0.0, 0.0]
    assert float(pushed(start, up[-1])[0]) > 50 * PIXEL


def test_a_part_starts_from_the_pose_to_which_those_before_it_have_pushed() -> None:
    """Two steps of one part each are one step of two parts."""
    pose = torch.tensor([0.0, 0.0, 0.3], dtype=torch.float64)
    start = PIXEL * torch.tensor([BESIDE - 10, 12.0], dtype=torch.float64)
    way = PIXEL * torch.tensor([[15.0, 2.0], [24.0, -9.0]], dtype=torch.float64)

    first = MOTION(pose, start + way[0], way[0])
    second = MOTION(first, start + way[1], way[1] - way[0])
    assert (first - pose).any() and (second - first).any()
    torch.testing.assert_close(MOTION(pose, start + way[1], way.flatten()), second)


def test_the_belief_moves_as_it_is_and_leads_no_gradient_to_the_push() -> None:
    pose = poses(1)[0].requires_grad_()
    pusher, way = (torch.ones(size, dtype=torch.float64, requires_grad=True) for size in (2, 4))
    moved = PoseMotion(ContactOptions(size=T_WIDTH).dynamics(body_of()), RADIUS)(pose, pusher, way)

    jacobian = torch.stack([torch.autograd.grad(x, pose, retain_graph=True)[0] for x in moved])
    torch.testing.assert_close(jacobian, torch.eye(3, dtype=torch.float64))
    assert not any(torch.autograd.grad(moved.sum(), (pusher, way), allow_unused=True))


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


# --- friction


def test_a_push_through_the_centre_is_the_same_with_friction() -> None:
    motion = PoseMotion(ContactOptions(size=T_WIDTH).dynamics(SQUARE), RADIUS, friction=0.2)
    way = PIXEL * torch.tensor([10.0, 0.0], dtype=torch.float64)
    start = PIXEL * torch.tensor([BESIDE, 0.0], dtype=torch.float64)
    moved = motion(torch.zeros(3, dtype=torch.float64), start + way, way)
    torch.testing.assert_close(moved, pushed((BESIDE, 0), (10, 0)))


def test_friction_takes_the_object_along_a_slanting_push() -> None:
    motion = PoseMotion(ContactOptions(size=T_WIDTH).dynamics(SQUARE), RADIUS, friction=0.2)
    way = PIXEL * torch.tensor([10.0, 10.0], dtype=torch.float64)
    start = PIXEL * torch.tensor([BESIDE, 0.0], dtype=torch.float64)
    moved = motion(torch.zeros(3, dtype=torch.float64), start + way, way)
    assert float(moved[1]) > 0 == float(pushed((BESIDE, 0), (10, 10))[1])
