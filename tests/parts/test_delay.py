"""Late readings: the history of motions, and what it makes of a position and of a pose."""

import torch
from _inputs import normal
from _inputs.pushing import RADIUS, body_of, outside, poses

from aicon_torch.models.pusht.benchmark import PIXEL, T_WIDTH
from aicon_torch.parts import (
    ContactOptions,
    CurrentPose,
    DelayedPoseMotion,
    MotionHistory,
    PoseMotion,
    current_position,
    delayed_position,
)
from aicon_torch.parts.servo import even_motion

BODY = body_of()
MOTION = PoseMotion(ContactOptions(size=T_WIDTH).dynamics(BODY), RADIUS)

LAST = torch.zeros(4, dtype=torch.float64)
"""A way in two parts, of which only the size is read."""


def test_the_history_begins_at_rest_and_forgets_the_oldest() -> None:
    history = MotionHistory(2, parts=1).double()
    past = history.initial({})["d_past"]
    assert past.tolist() == [0.0] * 4

    for last in ([1.0, 2.0], [3.0, 4.0], [5.0, 6.0]):
        past = history.update({"d_past": past, "d_pusher": torch.tensor(last)})["d_past"]
    assert past.tolist() == [3.0, 4.0, 5.0, 6.0]


def test_a_position_then_and_since_is_a_position_now() -> None:
    """All past steps together bring the pusher from where it was to where it is.

    The parts of a step but for the last are on the way, and do not count.
    """
    start, ways = normal(3, 2), normal(3, 4, 2, 2, seed=1)
    past, next_action = ways.flatten(1), normal(3, 2, seed=2)
    arrivals = ways[:, :, -1]

    then = delayed_position(start, past, LAST)
    torch.testing.assert_close(then, start + arrivals[:, 0])
    now = current_position(then, past, LAST, next_action, 0.1)
    torch.testing.assert_close(now, start + arrivals.sum(1))


def test_only_the_next_action_moves_a_position_to_come() -> None:
    past = normal(8).requires_grad_()
    action = normal(2, seed=1).requires_grad_()
    now = current_position(torch.zeros(2).double(), past, LAST, action, 0.1)

    by_past, by_action = torch.autograd.grad(now.sum(), (past, action), allow_unused=True)
    assert by_past is None
    assert by_action.tolist() == [0.1, 0.1]


def test_a_pose_is_moved_on_step_by_step() -> None:
    pose = poses(20)
    pusher, moves = outside(BODY, pose, 20 * PIXEL), 30 * PIXEL * normal(20, 3, 2, seed=1)
    ways = even_motion(moves, parts=2)
    past = ways.flatten(1)

    arrived = pusher + moves[:, 0]
    then = DelayedPoseMotion(MOTION)(pose, arrived, past, LAST)
    torch.testing.assert_close(then, MOTION(pose, arrived, ways[:, 0]))

    expected = then
    for step in (1, 2):
        arrived = arrived + moves[:, step]
        expected = MOTION(expected, arrived, ways[:, step])
    now = CurrentPose(MOTION)(then, pusher + moves[:, 0], past, LAST)
    torch.testing.assert_close(now, expected)
    assert (now - then).abs().amax() > 1e-3  # some were pushed
