"""Estimators of the object that is pushed: where it is, and where its corners are."""

from typing import Any

from aicon_torch.estimation import EKF, Deterministic, Estimator, LateEKF, Measurement
from aicon_torch.interconnections import Interconnection
from aicon_torch.models.pusht.benchmark import (
    PIXEL,
    PRIOR_DEVIATION,
    PUSHER_RADIUS,
    T_CENTER_OF_MASS,
    T_KEYPOINTS,
    T_OUTLINE_ORDER,
    T_RADIUS_OF_GYRATION,
)
from aicon_torch.models.pusht.options import Options
from aicon_torch.parts.contact_dynamics import ContactDynamics
from aicon_torch.parts.pose import (
    KeypointRegistration,
    PoseMotion,
    pose_jacobian,
    resting_pose,
)
from aicon_torch.parts.rigid_object import RigidObject

UNFILTERED_NOISE = 1e-6 * PIXEL
"""Standard deviation of keypoints that are taken as they come, m: next to nothing."""


def rigid_object(options: Options) -> RigidObject:
    """The object that the options describe: the benchmark's T unless they give other corners."""
    order, center = options.outline_order, options.center_of_mass
    gyration = options.radius_of_gyration
    if options.keypoints is not None:
        return RigidObject.of(options.keypoints, order, center, gyration)

    return RigidObject.of(
        T_KEYPOINTS,
        T_OUTLINE_ORDER if order is None else order,
        T_CENTER_OF_MASS if center is None else center,
        T_RADIUS_OF_GYRATION if gyration is None else gyration,
    )


def object_estimators(options: Options, dynamics: ContactDynamics, parts: int) -> list[Estimator]:
    """x_pose, x_keypoints: the object's pose, and its corners there.

    Args:
        options: The options.
        dynamics: What a push does.
        parts: Number of parts in which the pusher's way through a step is known.
    """
    placed = Interconnection(dynamics.body.keypoints_at, inputs=["x_pose"])
    return [_pose(options, dynamics, parts), Deterministic("x_keypoints", placed)]


def _pose(options: Options, dynamics: ContactDynamics, parts: int) -> EKF:
    """The pose as the keypoints show it."""
    body = dynamics.body
    motion = PoseMotion(dynamics, PUSHER_RADIUS) if options.estimation else resting_pose
    registration = KeypointRegistration(body, PRIOR_DEVIATION)
    residual = Interconnection(registration, x_pose=pose_jacobian)
    reading_noise = options.keypoint_noise if options.estimation else UNFILTERED_NOISE

    process = options.process_noise**2
    belief: dict[str, Any] = {
        "predict": Interconnection(motion, x_pose=pose_jacobian),
        "noise": (process, process, process / body.radius_of_gyration**2),
        "initial": registration.prior,
        "size": 3,
        "correct": [Measurement(residual, registration.variances(reading_noise), size=3)],
    }

    if not options.is_delayed:
        return EKF("x_pose", "P_pose", **belief)
    moved_by = {"x_pusher": 2, "d_pusher": 2 * parts}
    late: dict[str, Any] = {"sensor": "z_keypoints", "steps": options.delay, "moved_by": moved_by}
    return LateEKF("x_pose", "P_pose", **late, **belief)
