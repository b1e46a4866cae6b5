"""Estimators of the object that is pushed: where it is, and where its corners are."""

from collections.abc import Callable

from torch import Tensor

from aicon_torch.estimation import EKF, Deterministic, Estimator, Measurement
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
from aicon_torch.parts.delay import CurrentPose, DelayedPoseMotion
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


def object_estimators(options: Options, dynamics: ContactDynamics) -> list[Estimator]:
    """x_pose, x_keypoints: the object's pose, and its corners there."""
    body = dynamics.body
    motion = PoseMotion(dynamics, PUSHER_RADIUS)
    placed = Interconnection(body.keypoints_at, inputs=["x_pose"])
    keypoints = Deterministic("x_keypoints", placed)

    if not options.is_delayed:
        predict = motion if options.estimation else resting_pose
        return [_pose(options, body, "x_pose", "P_pose", predict), keypoints]

    # With a delay the pose of then is filtered, and moved on to now.
    return [
        _pose(options, body, "y_pose", "Q_pose", DelayedPoseMotion(motion)),
        Deterministic("x_pose", CurrentPose(motion)),
        keypoints,
    ]


def _pose(
    options: Options, body: RigidObject, name: str, covariance: str, predict: Callable[..., Tensor]
) -> EKF:
    """The pose as the keypoints show it."""
    jacobians: dict[str, Callable[..., Tensor]] = {name: pose_jacobian}
    registration = KeypointRegistration(body, PRIOR_DEVIATION)
    residual = Interconnection(registration, [name, "z_keypoints"], **jacobians)
    reading_noise = options.keypoint_noise if options.estimation else UNFILTERED_NOISE

    process = options.process_noise**2
    return EKF(
        name,
        covariance,
        predict=Interconnection(predict, None, **jacobians),
        noise=(process, process, process / body.radius_of_gyration**2),
        initial=registration.prior,
        size=3,
        correct=[Measurement(residual, registration.variances(reading_noise), size=3)],
    )
