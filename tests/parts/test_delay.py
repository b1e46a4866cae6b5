"""Late readings: the history of actions, and what it makes of a position and of a pose."""

import torch
from _inputs import normal
from _inputs.pushing import RADIUS, body_of, outside, poses

from aicon_torch.models.pusht.benchmark import PIXEL, T_WIDTH
from aicon_torch.parts import (
    ActionHistory,
    ContactOptions,
    CurrentPose,
    DelayedPoseMotion,
    PoseMotion,
    current_position,
    delayed_position,
)

BODY = body_of()
MOTION = PoseMotion(ContactOptions(size=T_WIDTH).dynamics(BODY), RADIUS)


def test_the_history_begins_at_rest_and_forgets_the_oldest() -> None:
    history = ActionHistory(2).double()
    past = history.initial({})["a_past"]
    assert past.tolist() == [0.0] * 4

    for last in ([1.0, 2.0], [3.0, 4.0], [5.0, 6.0]):
        past = history.update({"a_past": past, "a": torch.tensor(last)})["a_past"]
    assert past.tolist() == [3.0, 4.0, 5.0, 6.0]


def test_a_position_then_and_since_is_a_position_now() -> None:
    """All past actions together bring the pusher from where it was to where it is."""
    start, actions = normal(3, 2), normal(3, 4, 2, seed=1)
    past, next_action = actions.flatten(-2), normal(3, 2, seed=2)

    then = delayed_position(start, past, 0.1)
    torch.testing.assert_close(then, start + 0.1 * actions[:, 0])
    now = current_position(then, past, next_action, 0.1)
    torch.testing.assert_close(now, start + 0.1 * actions.sum(1))


def test_only_the_next_action_moves_a_position_to_come() -> None:
    past = normal(8).requires_grad_()
    action = normal(2, seed=1).requires_grad_()
    now = current_position(torch.zeros(2).double(), past, action, 0.1)

    by_past, by_action = torch.autograd.grad(now.sum(), (past, action), allow_unused=True)
    assert by_past is None
    assert by_action.tolist() == [0.1, 0.1]


def test_a_pose_is_moved_on_action_by_action() -> None:
    pose = poses(20)
    pusher, actions = outside(BODY, pose, 20 * PIXEL), 300 * PIXEL * normal(20, 3, 2, seed=1)
    past = actions.flatten(-2)

    arrived = pusher + 0.1 * actions[:, 0]
    then = DelayedPoseMotion(MOTION)(pose, arrived, past, 0.1)
    torch.testing.assert_close(then, MOTION(pose, arrived, actions[:, 0], 0.1))

    expected = then
    for step in (1, 2):
        arrived = arrived + 0.1 * actions[:, step]
        expected = MOTION(expected, arrived, actions[:, step], 0.1)
    now = CurrentPose(MOTION)(then, pusher + 0.1 * actions[:, 0], past, 0.1)
    torch.testing.assert_close(now, expected)
    assert (now - then).abs().amax() > 1e-3  # some were pushed
