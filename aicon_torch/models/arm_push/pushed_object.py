"""The object's estimators: its pose and the height of its top, seen and felt, or observed."""

from collections.abc import Sequence
from typing import Any

import torch

from aicon_torch.estimation import EKF, Deterministic, Estimator, Measurement, ekf_with_delay
from aicon_torch.interconnections import Affine, Constant, Interconnection
from aicon_torch.models.arm_push.measurements import (
    ObservedPose,
    SeenKeypoints,
    seen_middle,
    seen_top,
)
from aicon_torch.models.arm_push.options import Options
from aicon_torch.models.arm_push.perception import BLOB, KEYPOINTS
from aicon_torch.models.arm_push.scene import Scene
from aicon_torch.parts.camera import Visibility
from aicon_torch.parts.pose import PoseMotion
from aicon_torch.parts.touch import ForceThreshold, TouchedSide, TouchedTop

UNSEEN_DEVIATION = (0.1, 1 / 6, 2.0)
"""Standard deviation of the object's pose before it is seen, m, m and rad."""

UNOBSERVED_DEVIATION = 1 / 600
"""Standard deviation of its position before its pose is observed, m."""

MIDDLE_DEVIATION = 0.05
"""Standard deviation of the object's centre about the middle of what is seen of it, m."""

SIDE_FORCE = ForceThreshold(force=1.2, width=0.1)
"""Which horizontal force, N, says that the stick touches a side of the object: a tool that is
accelerated feels less."""

TOP_FORCE = ForceThreshold(force=2.0, width=0.15)
"""Which force upward, N, says that the stick stands on the object."""

SIDE_DEVIATION = 1 / 60
"""Standard deviation of the gap to a side that the wrist feels, m; it is felt at every step."""

TOP_DEVIATION = 1e-5**0.5
"""Standard deviation of the height of the top that the wrist feels, m."""

UNSEEN_TOP = 1e-4
"""Variance of the height of its top before it is seen, m²."""

TOP_DRIFT = 1e-9
"""Variance of the change of that height in a step, m²."""

TOP_NOISE = 1e-6
"""Variance of that height as the camera sees it, m²."""


def pushed_object(scene: Scene) -> list[Estimator]:
    """The object's pose, its keypoints there, and where it is to be."""
    pose = seen_pose(scene) if scene.options.sensing == "camera" else observed_pose(scene)
    keypoints = Interconnection(scene.body.keypoints_at, inputs=["x_pose"])
    target = Interconnection(scene.body.pose_of_frame, inputs=["z_target"])
    return [pose, Deterministic("x_keypoints", keypoints), Deterministic("x_target", target)]


def observed_pose(scene: Scene) -> EKF:
    """x_pose, corrected by a pose that is observed."""
    offset = torch.tensor(scene.options.pose_offset, dtype=torch.float64)
    observed = ObservedPose(scene.body, UNOBSERVED_DEVIATION, offset)
    residual = Interconnection(observed, x_pose=Constant(torch.eye(3)))
    reading = Measurement(residual, scene.body.pose_variances(scene.options.pose_noise), size=3)
    return _pushed_pose(
        scene,
        delay=scene.options.delay,
        sensor="z_object",
        initial=observed.prior,
        size=3,
        correct=[reading],
    )


def seen_pose(scene: Scene) -> EKF:
    """x_pose, corrected by what the camera shows and the wrist feels."""
    options = scene.options
    visibility = Visibility(
        options.robot.intrinsics,
        variances=scene.body.pose_variances(options.camera.noise),
        edge_growth=options.camera.edge_growth,
        height=2 * options.height,
    )

    # The camera shows its keypoints, or no more than its middle.
    seen = Interconnection(SeenKeypoints(scene.body), x_pose=Constant(torch.eye(3)))
    middle = Interconnection(seen_middle, x_pose=Constant(torch.eye(3)[:2]))
    shown = [
        Measurement(seen, visibility, size=3),
        Measurement(middle, MIDDLE_DEVIATION**2, size=2),
    ]

    # The wrist tells on which side the tip touches it.
    felt: list[Measurement] = []
    if options.touch:
        radius = options.robot.stick_radius
        touched = TouchedSide(scene.body, radius, SIDE_DEVIATION, SIDE_FORCE)
        felt.append(Measurement(touched, touched.variance, size=1))

    # Before it is seen it is where one expects it, give or take much.
    mean = (*options.expected_place, 0.0)
    variances = [deviation**2 for deviation in UNSEEN_DEVIATION]
    late: dict[str, Any] = {"delay": options.camera.delay, "sensor": (KEYPOINTS, BLOB)}
    return _pushed_pose(scene, felt, **late, initial=(mean, variances), correct=shown)


def _pushed_pose(scene: Scene, felt: Sequence[Measurement] = (), **belief: Any) -> EKF:
    """x_pose, predicted from what the tip has pushed; how it begins and is corrected is given."""
    options = scene.options
    motion = PoseMotion(scene.dynamics, options.robot.stick_radius, options.stick_friction)
    inputs = ["x_pose", "x_pusher", "d_pusher"]

    # A random walk, whose deviation grows with the root of the time.
    deviation = options.drift * options.dt**0.5
    moved_by = {"x_pusher": 2, "d_pusher": 2 * options.parts, "dt": 1}

    # After a late image the steps since are gone through again, with what was felt in each.
    if felt:
        moved_by["x_force"] = 3

    return ekf_with_delay(
        "x_pose",
        "P_pose",
        moved_by=moved_by,
        prompt=felt,
        predict=Interconnection(motion, inputs, x_pose=Constant(torch.eye(3))),
        noise=scene.body.pose_variances(deviation),
        **belief,
    )


def object_top(options: Options) -> EKF:
    """x_top: height of the object's top face, m, from the depth of its keypoints and by touch."""
    seen = Interconnection(seen_top, x_top=Constant(torch.eye(1)))
    correct = [Measurement(seen, TOP_NOISE, size=1)]
    if options.touch:
        touched = TouchedTop(TOP_DEVIATION, TOP_FORCE)
        correct.append(Measurement(touched, touched.variance, size=1))

    return EKF(
        "x_top",
        "P_top",
        predict=Affine(x_top=1.0),
        noise=TOP_DRIFT,
        initial=((2 * options.height,), UNSEEN_TOP),
        correct=correct,
    )
