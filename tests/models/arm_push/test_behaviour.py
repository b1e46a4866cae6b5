import pytest
import torch
from _inputs import driven, lean
from _inputs.arm import HOME, panda, pose_observation, postures

from aicon_torch import presets
from aicon_torch.models.arm_push import PANDA

OUT_OF_REACH = {
    "object_pose": torch.tensor([0.76, 0.05, 1.0]),
    "target": torch.tensor([0.5, 0.05, 1.0]),
}


def compiled(**options):
    return driven("arm_push", sensing="pose", **options)


def run(policy, q, steps, **changes):
    """The joint angles after each step, where the arm does what it is told."""
    memory, angles, q = None, [], q.clone()
    for _ in range(steps):
        action, memory = policy.predict(pose_observation(q=q, **changes), memory)
        q = q + 0.01 * action
        angles.append(q)
    return torch.stack(angles)


@pytest.mark.parametrize("preset", presets("arm_push"))
def test_every_preset_acts_within_the_limits(preset):
    policy, memory = lean("arm_push", preset=preset, sensing="pose"), None
    for _ in range(3):
        action, memory = policy.predict(pose_observation(), memory)
    assert action.isfinite().all() and (action.abs() <= PANDA.chain.speed).all()
    assert action.norm() > 0.01


def test_a_batch_is_its_rows():
    policy = lean("arm_push", sensing="pose")
    rows = pose_observation((3,)) | {"q": postures(3)}
    together, _ = policy.predict(rows)
    for row in range(3):
        single, _ = policy.predict({key: value[row] for key, value in rows.items()})
        torch.testing.assert_close(together[row], single, rtol=1e-6, atol=1e-9)


def test_height_is_a_goal_of_its_own():
    heights = panda()(run(compiled(), HOME, 100))[:, 2]
    assert abs(heights[-1] - 0.02) < abs(heights[0] - 0.02)


def test_near_a_limit_the_joint_turns_back():
    q = HOME.clone()
    q[6] = PANDA.chain.high[6] - 0.02
    last_joint = run(compiled(), q, 100)[:, 6]
    assert (last_joint < PANDA.chain.high[6]).all()
    assert last_joint[-1] < PANDA.chain.high[6] - 0.04


@pytest.mark.parametrize(
    ("options", "crosses"),
    [({}, False), pytest.param({"workspace": None}, True, marks=pytest.mark.slow)],
)
def test_the_elbow_does_not_bend_the_other_way_where_the_object_is_out_of_reach(options, crosses):
    elbow = run(compiled(**options), HOME, 400, **OUT_OF_REACH)[:, 3]
    assert (elbow.max() > -0.467) == crosses
