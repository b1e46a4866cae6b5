"""What the planner predicts, and what it costs."""

from typing import Any

import pytest
import torch
from torch import Tensor

pytest.importorskip("pytorch_mppi")
pytest.importorskip("pymunk")

from aicon_baselines.agents.mppi import Options
from aicon_baselines.agents.mppi.cost import Cost
from aicon_baselines.agents.mppi.prediction import Prediction
from aicon_baselines.tasks import load
from aicon_torch.models import pusht
from aicon_torch.models.pusht import PIXEL
from aicon_torch.parts.planar import rotate

FREE = (0.1, 0.1)  # m, far from the object
STILL = torch.zeros(2, dtype=torch.float64)


@pytest.fixture
def prediction() -> Prediction:
    return Prediction(pusht.Options())


def goal_of(prediction: Prediction) -> Tensor:
    frame = torch.tensor(pusht.Options().goal_pose, dtype=torch.float64)
    return prediction.body.pose_of_frame(frame)


def state(pose: Tensor, pusher: Any) -> Tensor:
    """A pusher at rest somewhere."""
    return torch.cat((pose, torch.as_tensor(pusher, dtype=torch.float64), STILL))


def beside(prediction: Prediction, pose: Tensor, distance: float) -> Tensor:
    """Where the centre of a pusher is so far out from the middle of the T's long side, m."""
    in_body = torch.tensor([0.0, -distance], dtype=torch.float64)
    return pose[:2] + rotate(in_body - prediction.body.center_of_mass, pose[2])


def test_far_from_the_object_the_pusher_moves_alone_and_as_fast_as_told(
    prediction: Prediction,
) -> None:
    before = state(goal_of(prediction), FREE)
    velocity = torch.tensor([0.1, -0.05], dtype=torch.float64)
    after = prediction(before, velocity)
    assert torch.allclose(after[:3], before[:3])
    assert torch.allclose(after[3:5], before[3:5] + prediction.dt * velocity)


def test_a_free_motion_is_that_of_the_environment(prediction: Prediction) -> None:
    task = load("pusht")
    env = task.make_env(1, "deterministic", 300)
    observation, _ = env.reset(seed=1000, options={"per_env": [{}]})

    keypoints = PIXEL * torch.as_tensor(observation["environment_state"], dtype=torch.float64)
    pose = prediction.body.registration(keypoints.unflatten(-1, (-1, 2)))[0]
    pusher = PIXEL * torch.as_tensor(observation["agent_pos"], dtype=torch.float64)[0]
    away = (pusher - pose[:2]) / (pusher - pose[:2]).norm()

    # Away from the object, faster and slower.
    expected = state(pose, pusher)
    for speed in (0.1, 0.3, 0.0):
        moved = prediction(expected, speed * away)
        target = pusher_target(prediction, expected, speed * away)
        observation, *_ = env.step((target / PIXEL).numpy()[None])
        seen = PIXEL * torch.as_tensor(observation["agent_pos"], dtype=torch.float64)[0]
        assert torch.allclose(moved[3:5], seen, atol=0.05 * PIXEL)
        expected = moved
    env.close()


def pusher_target(prediction: Prediction, before: Tensor, velocity: Tensor) -> Tensor:
    """The position target that yields a mean velocity."""
    offset = prediction.servo.target_offset(velocity, before[5:], prediction.dt)
    return before[3:5] + offset


@pytest.mark.parametrize("speed", [0.1, 0.4, 0.8])
def test_a_push_moves_the_object_ahead_of_the_pusher_however_fast(
    prediction: Prediction, speed: float
) -> None:
    pose = goal_of(prediction)
    pusher = beside(prediction, pose, 16 * PIXEL)
    towards = (pose[:2] - pusher) / (pose[:2] - pusher).norm()

    after = prediction(state(pose, pusher), speed * towards)
    pushed = ((after[:2] - pose[:2]) * towards).sum()
    assert pushed > 0.5 * (speed * prediction.dt - PIXEL)
    assert ((after[:2] - after[3:5]) * towards).sum() > 0  # it is still behind it


def test_the_cost_is_the_pose_error_and_the_way_to_the_object(prediction: Prediction) -> None:
    goal = goal_of(prediction)
    options = Options(gap_weight=0.1)
    cost = Cost(prediction.dynamics, goal, options)

    # Nothing, where everything is as it should be, in contact.
    touching, apart = (beside(prediction, goal, px * PIXEL) for px in (15, 65))
    assert cost(state(goal, touching), STILL) == pytest.approx(0.0, abs=1e-6)
    assert cost(state(goal, apart), STILL) == pytest.approx(5 * PIXEL, rel=1e-3)

    # A shift of the object and of the pusher with it.
    shift = torch.tensor([0.03, 0.04, 0.0], dtype=torch.float64)
    shifted = state(goal + shift, touching + shift[:2])
    assert cost(shifted, STILL) == pytest.approx(0.05, rel=1e-3)
