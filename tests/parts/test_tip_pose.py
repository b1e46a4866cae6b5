import math

import pytest
import torch
from _inputs import normal
from _inputs.arm import panda_chain, postures
from torch import Tensor

from aicon_torch.errors import OptionError
from aicon_torch.parts.end_effector import EndEffector
from aicon_torch.parts.pose_reach import PoseReach
from aicon_torch.parts.tip_pose import Orientation, TipPose, rotation_of_quaternion

ORIENTATIONS: tuple[Orientation, ...] = ("free", "axis", "full")


def turned(angle: float, axis: tuple[float, float, float] = (0.0, 0.0, 1.0)) -> Tensor:
    """The transform of a tip that is turned about an axis."""
    w, sine = math.cos(angle / 2), math.sin(angle / 2)
    transform = torch.eye(4, dtype=torch.float64)
    quaternion = [w, *(sine * component for component in axis)]
    transform[:3, :3] = rotation_of_quaternion(torch.tensor(quaternion, dtype=torch.float64))
    return transform


@pytest.mark.parametrize("orientation", ORIENTATIONS)
def test_the_jacobian_is_the_derivative(orientation: Orientation) -> None:
    arm = EndEffector(panda_chain(), TipPose(orientation, axis=(0.0, 0.6, 0.8)), "transpose")
    q = postures(4)
    expected = torch.autograd.functional.jacobian(lambda x: arm(x).sum(0), q).permute(1, 0, 2)
    torch.testing.assert_close(arm.jacobian(q), expected)
    assert arm(q).shape == (4, arm.pose.size)


@pytest.mark.parametrize("orientation", ["axis", "full"])
@pytest.mark.parametrize("angle", [1e-3, 0.5, 2.0, 3.1])
def test_the_distance_of_a_turn_is_its_angle(orientation: Orientation, angle: float) -> None:
    pose, axis = TipPose(orientation), (1.0, 0.0, 0.0)
    distance, found = pose.distance(pose.of_frame(turned(angle, axis)), pose.of_frame(turned(0.0)))
    assert distance == pytest.approx(0.0, abs=1e-9)
    assert found == pytest.approx(angle, abs=1e-6)


def test_a_turn_about_the_axis_does_not_matter_to_the_axis() -> None:
    pose = TipPose("axis")
    _, found = pose.distance(pose.of_frame(turned(2.0)), pose.of_frame(turned(0.0)))
    assert found == pytest.approx(0.0, abs=1e-9)


def test_a_target_is_what_a_tip_would_be_there() -> None:
    tool, quaternion = turned(0.7, (0.0, 0.6, 0.8)), [math.cos(0.35), 0.0, 0.0, 0.0]
    quaternion[2:] = [0.6 * math.sin(0.35), 0.8 * math.sin(0.35)]
    position = tool[:3, 3]

    full = TipPose("full")
    target = full.target(position, 3 * torch.tensor(quaternion, dtype=torch.float64))
    torch.testing.assert_close(target, full.of_frame(tool))

    axis = TipPose("axis")
    torch.testing.assert_close(axis.target(position, 2 * tool[:3, 2]), axis.of_frame(tool))


@pytest.mark.parametrize("orientation", ORIENTATIONS)
def test_a_turn_counts_as_the_lever_says(orientation: Orientation) -> None:
    """‖dx_ee‖ = L·δ for a turn by a small δ about what matters."""
    pose, small = TipPose(orientation, lever=0.3), 1e-4
    axis = (1.0, 0.0, 0.0)
    moved = pose.of_frame(turned(small, axis)) - pose.of_frame(turned(0.0))
    expected = 0.0 if orientation == "free" else 0.3 * small
    assert moved.norm() == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("orientation", ORIENTATIONS)
def test_the_cost_falls_by_what_the_tip_moves_toward_the_target(orientation: Orientation) -> None:
    """The gradient of g by x_ee, pulled back along J⁺, is the way straight to the target."""
    arm = EndEffector(panda_chain(), TipPose(orientation), damping=1e-6)
    goal, q = PoseReach(arm.pose), postures(5)
    target = arm(q + 0.02 * normal(5, 7, seed=3))

    q = q.requires_grad_()
    cost = goal(arm(q), target)
    (slope,) = torch.autograd.grad(cost.sum(), q)
    step = cost.detach() / slope.norm(dim=-1)
    reached = arm(q.detach() - step.unsqueeze(-1) * slope / slope.norm(dim=-1, keepdim=True))
    assert (goal(reached, target) < 0.1 * cost.detach()).all()


def test_within_its_tolerance_a_target_asks_for_nothing() -> None:
    goal = PoseReach(TipPose("free"), tolerance=0.01)
    x_ee = torch.tensor([0.006, 0.0, 0.0], requires_grad=True)
    cost = goal(x_ee, torch.zeros(3))
    (slope,) = torch.autograd.grad(cost, x_ee)
    assert cost == 0
    assert (slope == 0).all()


def test_wrong_options_are_named() -> None:
    with pytest.raises(OptionError, match="orientation='round': expected one of"):
        TipPose("round")  # type: ignore[arg-type]
    with pytest.raises(OptionError, match=r"lever=0: expected a length > 0"):
        TipPose(lever=0)
    with pytest.raises(OptionError, match="expected a unit vector"):
        TipPose("axis", axis=(1.0, 1.0, 0.0))
