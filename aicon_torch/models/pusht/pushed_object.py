"""Estimators of the object that is pushed: where it is, and where its corners are."""

from collections.abc import Callable

import torch
from torch import Tensor
from torch.nn.functional import pad

from aicon_torch.estimation import EKF, Deterministic, Estimator, Measurement, Noise, ekf_with_delay
from aicon_torch.interconnections import Affine, Constant, Interconnection
from aicon_torch.models.pusht.benchmark import (
    PIXEL,
    PRIOR_DEVIATION,
    PROCESS_NOISE,
    PUSHER_RADIUS,
    T_CENTER_OF_MASS,
    T_KEYPOINTS,
    T_OUTLINE_ORDER,
    T_RADIUS_OF_GYRATION,
)
from aicon_torch.models.pusht.options import Options
from aicon_torch.models.pusht.picture import first_sight, seen_off, seen_variances
from aicon_torch.parts.contact_dynamics import ContactDynamics
from aicon_torch.parts.keypoint_offset import KeypointOffset
from aicon_torch.parts.pose import KeypointRegistration, PoseMotion, PushNoise, resting_pose
from aicon_torch.parts.rigid_object import RigidObject

UNFILTERED_NOISE = 1e-6 * PIXEL
"""Standard deviation of keypoints that are taken as they come, m: next to nothing."""

TOUCH_DEVIATION = 1.0 * PIXEL
"""Standard deviation of the gap to an object that is touched, m: in the simulation they overlap."""

LEAST_MOTION, MOTION_DEVIATIONS = 0.5 * PIXEL, 6.0
"""Motion of a keypoint from which on the object was pushed, m, besides what is noise."""

OFFSET_DRIFT = 0.01 * PIXEL
"""Standard deviation of the change of an offset in a step, m."""


Prior = Callable[[Tensor], tuple[Tensor, Tensor]]
"""Mean and covariance of a pose by the first reading."""


def rigid_object(options: Options) -> RigidObject:
    """The object that the options describe: the benchmark's T unless they give other corners."""
    order, center = options.outline_order, options.center_of_mass
    gyration = options.radius_of_gyration

    # An object of somebody's own has none of the T's numbers.
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
    estimators = [_pose(options, dynamics, parts), Deterministic("x_keypoints", placed)]
    return [*estimators, _offset(options, dynamics.body)] if options.keypoint_offset else estimators


def _offset(options: Options, body: RigidObject) -> EKF:
    """x_offset: by how much all keypoints are off, as the pusher that touches the object tells."""
    least_motion = LEAST_MOTION + MOTION_DEVIATIONS * options.keypoint_noise
    gap = KeypointOffset(body, PUSHER_RADIUS, TOUCH_DEVIATION, least_motion)
    reading = Interconnection(gap.gap, x_offset=gap.gap_jacobian)

    # By the pose that was seen last it is the identity, and by the offset nothing.
    last_pose = Interconnection(gap.last_pose, x_offset=Constant(torch.eye(5)[2:]))

    return EKF(
        "x_offset",
        "P_offset",
        predict=Affine(x_offset=1.0),
        noise=(OFFSET_DRIFT**2, OFFSET_DRIFT**2, 1.0, 1.0, 1.0),  # the last pose is forgotten
        initial=gap.prior(options.keypoint_offset),
        size=5,
        correct=[
            Measurement(reading, gap.variance),
            Measurement(last_pose, UNFILTERED_NOISE**2, size=3),
        ],
    )


def _pose(options: Options, dynamics: ContactDynamics, parts: int) -> EKF:
    """x_pose: predicted from what the pusher did, and corrected by what is seen."""
    # Without estimation nothing is predicted, and readings are taken as they come.
    motion = PoseMotion(dynamics, PUSHER_RADIUS) if options.estimation else resting_pose
    see = _as_keypoints if options.picture is None else _in_picture
    prior, reading = see(options, dynamics.body)

    return ekf_with_delay(
        "x_pose",
        "P_pose",
        delay=options.filtered_delay,
        sensor="z_keypoints",
        moved_by={"x_pusher": 2, "d_pusher": 2 * parts, "dt": 1},
        predict=Interconnection(motion, x_pose=Constant(torch.eye(3))),
        noise=_process_noise(options, dynamics),
        initial=prior,
        size=3,
        correct=[reading],
    )


def _as_keypoints(options: Options, body: RigidObject) -> tuple[Prior, Measurement]:
    """The pose as the keypoints show it, less the offset that they may have."""
    registration = KeypointRegistration(body, PRIOR_DEVIATION)

    def without_offset(x_pose: Tensor, z_keypoints: Tensor, x_offset: Tensor) -> Tensor:
        # What is seen is off by the offset: x_pose + offset = seen.
        return registration(x_pose, z_keypoints) + pad(x_offset[..., :2], (0, 1))

    residual = without_offset if options.keypoint_offset else registration
    agreement = Interconnection(residual, x_pose=Constant(torch.eye(3)))
    noise = options.keypoint_noise if options.estimation else UNFILTERED_NOISE
    return registration.prior, Measurement(agreement, registration.variances(noise), size=3)


def _in_picture(options: Options, body: RigidObject) -> tuple[Prior, Measurement]:
    """The pose as a network sees it in a picture, with the variances that it tells or with others.

    The first estimate has the covariance that it tells in either case.
    """
    # What the network tells of each picture, what the options say of all, or next to nothing.
    noise: Noise = seen_variances
    if options.picture_noise is not None:
        noise = body.pose_variances(options.picture_noise)
    if not options.estimation:
        noise = UNFILTERED_NOISE**2
    return first_sight, Measurement(seen_off, noise, size=3)


def _process_noise(options: Options, dynamics: ContactDynamics) -> Noise:
    """What moves the object in a step besides the model: the same at all times, or by the push."""
    if options.push_noise:
        pushed = PoseMotion(dynamics, PUSHER_RADIUS)
        return PushNoise(pushed, PROCESS_NOISE, options.push_noise)
    return dynamics.body.pose_variances(PROCESS_NOISE)
