"""An arm that was held up comes to its target along the axis of its tool."""

import pytest
import torch
from _inputs import normal
from _inputs.arm import panda_chain, postures
from torch import Tensor

from aicon_torch.errors import OptionError
from aicon_torch.parts import Approach, EndEffector, TipPose, ToolAxis

POSE = TipPose("full", lever=0.2)
AXIS = ToolAxis(POSE, within=0.28)
SPEED, DT = 1.5, 0.02


def pose_at(*position: float) -> Tensor:
    """A tip that points along z at a place, ``(1, 12)``."""
    upright = torch.tensor([[1.0, 0.0, 0.0, 0.0]], dtype=torch.float64)
    return POSE.target(torch.tensor([position], dtype=torch.float64), upright)


@pytest.mark.parametrize(("beside", "share"), [(0.0, 1.0), (0.28, 1 / 2), (0.84, 1 / 10)])
def test_an_advance_counts_the_less_the_farther_beside_the_axis(
    beside: float, share: float
) -> None:
    gradient = normal(1, 12)
    gated = AXIS.gated(gradient, pose_at(beside, 0.0, -0.5), pose_at(0.0, 0.0, 0.0))
    expected = gradient.clone()
    expected[:, 2] *= share
    torch.testing.assert_close(gated, expected)


def test_behind_its_target_a_tip_comes_back_as_ever() -> None:
    gradient = normal(1, 12)
    gated = AXIS.gated(gradient, pose_at(0.5, 0.0, 0.1), pose_at(0.0, 0.0, 0.0))
    torch.testing.assert_close(gated, gradient)


@pytest.mark.parametrize("axis", [(1.0, 0.0, 0.0), (0.6, 0.0, 0.8)])
def test_the_axis_of_a_pose_is_that_of_the_tool(axis: tuple[float, float, float]) -> None:
    tool = panda_chain()(postures(5))
    expected = tool[:, :3, :3] @ torch.tensor(axis, dtype=torch.float64)
    for orientation in ("axis", "full"):
        pose = TipPose(orientation, lever=0.2, axis=axis)
        torch.testing.assert_close(pose.axis_of(pose.of_frame(tool)), expected)


def stepped(approach: Approach, q: Tensor, target: Tensor, steps: int, known: Tensor) -> Tensor:
    """x_approach after some steps at rest."""
    for _ in range(steps):
        values = {"x_approach": known, "x_joints": q, "x_target": target, "dt": q.new_tensor(DT)}
        known = approach.update(values)["x_approach"]
    return known


def test_the_direct_way_is_closed_once_the_tip_comes_no_nearer_until_the_target_is_another() -> (
    None
):
    chain, q = panda_chain(), postures(1)
    approach = Approach(chain, POSE, SPEED)
    target, other = pose_at(0.5, 0.0, 0.3), pose_at(0.5, 0.2, 0.3)
    known = approach.initial({})["x_approach"].to(q).expand(1, -1)

    patience = round(0.45 / SPEED / DT)
    known = stepped(approach, q, target, patience, known)
    assert known[:, 0] == 0.0
    known = stepped(approach, q, target, 2, known)
    assert known[:, 0] == 1.0

    # It stays closed where the arm has moved on, and another target may be open.
    assert stepped(approach, postures(1, seed=1), target, 1, known)[:, 0] == 1.0
    assert stepped(approach, q, other, 1, known)[:, 0] == 0.0


def test_a_closed_way_changes_where_the_joints_go_and_an_open_one_does_not() -> None:
    chain, q, target = panda_chain(), postures(4), POSE.of_frame(panda_chain()(postures(4, seed=3)))
    plain = EndEffector(chain, POSE)
    gated = EndEffector(chain, POSE, advance=AXIS)
    h = normal(4, 12)

    def joint_gradient(end_effector: EndEffector, closed: float) -> Tensor:
        at = q.clone().requires_grad_()
        x_approach = torch.full((4, 6), closed, dtype=torch.float64)
        (found,) = torch.autograd.grad((h * end_effector(at, target, x_approach)).sum(), at)
        return found

    torch.testing.assert_close(joint_gradient(gated, 0.0), joint_gradient(plain, 1.0))
    assert (joint_gradient(gated, 1.0) - joint_gradient(plain, 1.0)).abs().amax() > 1e-3


def test_a_target_of_free_orientation_has_no_axis() -> None:
    with pytest.raises(OptionError, match="its orientation is free"):
        ToolAxis(TipPose("free"), 0.28)
    with pytest.raises(OptionError, match="within=0: expected a distance > 0"):
        ToolAxis(POSE, 0)
