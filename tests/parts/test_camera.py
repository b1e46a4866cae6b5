import pytest
import torch
from _inputs import normal
from _inputs.arm import HOME, panda, postures, tool_pose

from aicon_torch.models.arm_push import PANDA
from aicon_torch.parts.camera import CameraFrame, Visibility, split_frame, to_world

VISIBILITY = Visibility(PANDA.intrinsics, (1.0, 1.0, 1.0), edge_growth=100.0, height=0.04)


def test_the_camera_is_where_the_tool_holds_it():
    arm = panda()
    frames = arm.chain.frames(postures(4))
    rotation, position = split_frame(CameraFrame(tool_pose(), PANDA.camera)(arm.at(frames)))
    mount = torch.tensor([*PANDA.camera, (0.0, 0.0, 0.0, 1.0)], dtype=torch.float64)
    expected = frames[:, 7] @ mount
    torch.testing.assert_close(rotation, expected[:, :3, :3])
    torch.testing.assert_close(position, expected[:, :3, 3])


@pytest.mark.parametrize(
    ("steering", "moves"),
    [("heading", [2, 5]), ("orientation", [2, 3, 4, 5]), ("all", [0, 1, 2, 3, 4, 5])],
)
def test_only_the_chosen_components_move_to_see_better(steering, moves):
    x_ee = panda()(postures(1)[0]).requires_grad_()
    camera = CameraFrame(tool_pose(), PANDA.camera, steering)
    (slope,) = torch.autograd.grad((camera(x_ee) * normal(12)).sum(), x_ee)
    assert slope.nonzero().flatten().tolist() == moves


def test_points_go_from_the_camera_to_the_world():
    x_cam = CameraFrame(tool_pose(), PANDA.camera)(panda()(postures(2)))
    rotation, position = split_frame(x_cam)
    ahead = torch.tensor([0.0, 0.0, 0.3], dtype=torch.float64).expand(2, 1, 3)
    expected = position + 0.3 * rotation[..., 2]
    torch.testing.assert_close(to_world(x_cam, ahead)[:, 0], expected)


def test_the_image_of_a_point_on_the_optical_axis_is_in_the_middle():
    x_cam = CameraFrame(tool_pose(), PANDA.camera)(panda()(HOME))
    rotation, position = split_frame(x_cam)
    depth = (VISIBILITY.height - position[2]) / rotation[2, 2]
    point = position + depth * rotation[:, 2]
    u, v = VISIBILITY.image_point(torch.cat((point[:2], torch.zeros(1))), x_cam)
    assert abs(u) < 1e-9 and abs(v) < 1e-9


def test_what_is_near_the_edge_of_the_image_is_seen_less_well():
    x_cam = CameraFrame(tool_pose(), PANDA.camera)(panda()(HOME))
    below, noise = x_cam[9:11], []
    for shift in (0.0, 0.1, 0.25, 0.7):
        x_pose = torch.cat((below + shift, torch.zeros(1)))
        noise.append(float(VISIBILITY(x_pose, x_cam)[0]))
    assert noise == sorted(noise) and noise[-1] > 100 * noise[0]


def test_the_object_does_not_follow_the_camera():
    x_cam = CameraFrame(tool_pose(), PANDA.camera)(panda()(HOME)).requires_grad_()
    x_pose = torch.tensor([0.5, 0.1, 0.0], dtype=torch.float64, requires_grad=True)
    slopes = torch.autograd.grad(
        VISIBILITY(x_pose, x_cam).sum(), (x_pose, x_cam), allow_unused=True
    )
    assert slopes[0] is None and slopes[1].abs().sum() > 0


def test_behind_the_camera_the_variance_is_large_and_finite():
    x_cam = CameraFrame(tool_pose(), PANDA.camera)(panda()(HOME))
    high = Visibility(PANDA.intrinsics, (1.0, 1.0, 1.0), edge_growth=100.0, height=2.0)
    variances = high(torch.tensor([0.9, 0.3, 0.0], dtype=torch.float64), x_cam)
    assert variances.isfinite().all() and (variances > 100).all()


def test_a_wrong_steering_is_named():
    with pytest.raises(ValueError, match="steering='zoom': expected one of 'heading'"):
        CameraFrame(tool_pose(), PANDA.camera, "zoom")
