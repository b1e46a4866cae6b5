"""Pushing an object to a target pose (Sect. "pushT: Object Pushing in Simulation").

A disc pushes a polygon of which it sees the corners. For each side of the polygon two gradients
lead from the pose error to the pusher: p₁ through the likelihood of a contact there, p₂ through its
position. The world is that of gym-pusht, with y pointing down and a PD controller that moves the
pusher to position targets; its px become metres at the sensors, and px again at the actuator.

What is ours beyond the text is an option of its own: likelihoods that differ for contacts that help
and contacts that harm, the quasi-static effect of a contact, magnitudes relative to the largest,
conflicts with any opposing gradient, and limits of the motion near contact.
"""

from collections.abc import Callable

import torch
from torch import Tensor

from aicon_torch.control import Policy
from aicon_torch.estimation import EKF, Deterministic, Estimator, KalmanFilter, Measurement
from aicon_torch.goals import Goal
from aicon_torch.graph import WorldModel
from aicon_torch.interconnections import Affine, Interconnection
from aicon_torch.models.pusht import benchmark
from aicon_torch.models.pusht.benchmark import PIXEL
from aicon_torch.models.pusht.options import Options
from aicon_torch.parts.contact import closest_point, fixed_closest_point
from aicon_torch.parts.contact_dynamics import ContactDynamics
from aicon_torch.parts.contact_options import SlowApproachOptions
from aicon_torch.parts.delay import (
    ActionHistory,
    CurrentPose,
    DelayedPoseMotion,
    current_position,
    delayed_position,
)
from aicon_torch.parts.pose import (
    FixedTarget,
    KeypointRegistration,
    PoseDistance,
    PoseMotion,
    pose_jacobian,
    resting_pose,
)
from aicon_torch.parts.rigid_object import RigidObject
from aicon_torch.parts.servo import PositionTarget, Servo
from aicon_torch.quantities import Actuator, Sensor


def build(options: Options) -> Policy:
    """The pushing policy."""
    return Policy(world_model(options), options.resolution, options.law)


def world_model(options: Options) -> WorldModel:
    """The graph of the paper's pushT, with its paths p₁ and p₂ for each side."""
    body = rigid_object(options)
    dynamics = options.contact.dynamics(body)
    servo = Servo.of(substep=benchmark.SUBSTEP, substeps=options.substeps)
    return WorldModel(
        sensors=_sensors(options, body),
        actuators={"a": _actuator(options, dynamics, servo)},
        estimators=[
            *_pusher(options, servo),
            *_object(options, dynamics),
            _target(options, body),
            *_contacts(options, body),
            Deterministic("x_obj", dynamics),
        ],
        goals=[Goal("push", PoseDistance(dynamics.rotation_length))],
        dt=options.dt,
        dtype=options.dtype,
    )


def rigid_object(options: Options) -> RigidObject:
    """The object that the options describe: the benchmark's T unless they give other corners."""
    order, center = options.outline_order, options.center_of_mass
    gyration = options.radius_of_gyration
    if options.keypoints is not None:
        return RigidObject.of(options.keypoints, order, center, gyration)

    return RigidObject.of(
        benchmark.T_KEYPOINTS,
        benchmark.T_OUTLINE_ORDER if order is None else order,
        benchmark.T_CENTER_OF_MASS if center is None else center,
        benchmark.T_RADIUS_OF_GYRATION if gyration is None else gyration,
    )


# --- Sensors and actuator: where px become metres, and metres px.


def _sensors(options: Options, body: RigidObject) -> dict[str, Sensor]:
    """What is read, px in m; pusher and object may be out of sight for a while."""
    coordinates = 2 * len(body.keypoints)
    sensors = {
        "z_pusher": Sensor(2, "m", key="agent_pos", optional=True, scale=PIXEL),
        "z_keypoints": Sensor(
            coordinates, "m", key="environment_state", optional=True, scale=PIXEL
        ),
    }
    if options.observe_goal:
        scale = (PIXEL, PIXEL, 1.0)
        sensors["z_target"] = Sensor(3, "m, m, rad", key="goal_pose", scale=scale)
    return sensors


def _actuator(options: Options, dynamics: ContactDynamics, servo: Servo) -> Actuator:
    """The pusher's velocity, its limits and what is sent in its place."""
    return Actuator(
        2,
        "m/s",
        limit=options.max_speed,
        constraints=_limits(options, dynamics, servo),
        command=_command(options, servo),
    )


def _command(options: Options, servo: Servo) -> Callable[..., Tensor]:
    """What the environment is sent: a position target in px, or a velocity in px/s."""
    target = PositionTarget(servo if options.compensate_lag else None, benchmark.WORKSPACE)

    def position_in_pixels(a: Tensor, x_pusher: Tensor, v_pusher: Tensor, dt: float) -> Tensor:
        return target(a, x_pusher, v_pusher, dt) / PIXEL

    def velocity_in_pixels(a: Tensor) -> Tensor:
        return a / PIXEL

    return position_in_pixels if options.command == "position" else velocity_in_pixels


def _limits(
    options: Options, dynamics: ContactDynamics, servo: Servo
) -> list[Callable[..., Tensor]]:
    """What limits the motion near contact; they are ours, and the text has none."""
    radius, size = benchmark.PUSHER_RADIUS, options.contact.size
    if options.contact_limits is None:
        return []
    if isinstance(options.contact_limits, SlowApproachOptions):
        return [options.contact_limits.limit(dynamics.rotation_length, radius, size)]

    follower = servo if options.command == "position" else None
    return [options.contact_limits.limits(dynamics, radius, size, follower)]


# --- The pusher.


def _pusher(options: Options, servo: Servo) -> list[Estimator]:
    """The pusher's position and velocity."""
    velocity = _pusher_velocity(options, servo)
    if not options.is_delayed:
        motion = Affine(x_pusher=1.0, a=options.dt)
        return [_pusher_position(options, "x_pusher", "P_pusher", motion), velocity]

    return [
        ActionHistory(options.delay + 1),
        _pusher_position(options, "y_pusher", "Q_pusher", delayed_position),
        Deterministic("x_pusher", current_position),
        velocity,
    ]


def _pusher_position(
    options: Options, name: str, covariance: str, motion: Callable[..., Tensor] | Affine
) -> EKF:
    """The position as it is read: that of now, or with a delay that of then."""
    variance = options.pusher_noise**2 if options.estimation else 1e-9 * PIXEL**2
    agreement = Affine(**{name: 1.0, "z_pusher": -1.0})
    return EKF(
        name,
        covariance,
        predict=motion,
        noise=options.process_noise**2,
        initial=first_position,
        size=2,
        correct=[Measurement(agreement, variance, size=2)],
    )


def first_position(z_pusher: Tensor) -> tuple[Tensor, Tensor]:
    """The prior at the first reading: mean ``(*B, 2)``, m, and covariance ``(2, 2)``, m²."""
    identity = torch.eye(2, dtype=z_pusher.dtype, device=z_pusher.device)
    return z_pusher, benchmark.PRIOR_DEVIATION**2 * identity


def _pusher_velocity(options: Options, servo: Servo) -> KalmanFilter:
    """The velocity as the PD controller leaves it; one that is commanded is there at once."""
    change = Affine(v_pusher=0.0, a=1.0)
    if options.command == "position":
        by_motion = servo.velocity_by_offset / servo.displacement_by_offset[-1]
        kept = servo.velocity_by_velocity - by_motion * servo.displacement_by_velocity[-1]
        change = Affine(v_pusher=kept, a=by_motion * options.dt)
    return KalmanFilter(
        "v_pusher",
        "P_velocity",
        predict=change,
        noise=PIXEL**2,
        initial=((0.0, 0.0), PIXEL**2),
    )


# --- The object.


def _object(options: Options, dynamics: ContactDynamics) -> list[Estimator]:
    """The object's pose, and its keypoints there."""
    motion = PoseMotion(dynamics, benchmark.PUSHER_RADIUS)
    place = Interconnection(dynamics.body.keypoints_at, inputs=["x_pose"])
    keypoints = Deterministic("x_keypoints", place)
    if not options.is_delayed:
        predict = motion if options.estimation else resting_pose
        return [_object_pose(options, dynamics.body, "x_pose", "P_pose", predict), keypoints]

    return [
        _object_pose(options, dynamics.body, "y_pose", "Q_pose", DelayedPoseMotion(motion)),
        Deterministic("x_pose", CurrentPose(motion)),
        keypoints,
    ]


def _object_pose(
    options: Options, body: RigidObject, name: str, covariance: str, predict: Callable[..., Tensor]
) -> EKF:
    """The pose as it is read: that of now, or with a delay that of then."""
    jacobians: dict[str, Callable[..., Tensor]] = {name: pose_jacobian}
    registration = KeypointRegistration(body, benchmark.PRIOR_DEVIATION)
    residual = Interconnection(registration, [name, "z_keypoints"], **jacobians)
    reading_noise = options.keypoint_noise if options.estimation else 1e-6 * PIXEL

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


def _target(options: Options, body: RigidObject) -> Deterministic:
    """x_target: the object's pose at the goal, observed or fixed."""
    if options.observe_goal:
        observed = Interconnection(body.pose_of_frame, inputs=["z_target"])
        return Deterministic("x_target", observed)

    frame = torch.tensor(tuple(options.goal_pose), dtype=torch.float64)
    return Deterministic("x_target", FixedTarget(body.pose_of_frame(frame)))


# --- The contacts, one for each side.


def _contacts(options: Options, body: RigidObject) -> list[Estimator]:
    """The sides, the closest point of each, and how likely a contact there is."""
    point = closest_point if options.position_path else fixed_closest_point
    return [
        Deterministic("x_side", body.sides),
        Deterministic("x_contact", point, each=["x_side"]),
        Deterministic("p_contact", _likelihood(options), each=["x_side", "x_contact"]),
    ]


def _likelihood(options: Options) -> Callable[..., Tensor]:
    """p_contact, with or without the path p₁."""
    likelihood = options.contact.likelihood(benchmark.PUSHER_RADIUS)

    def fixed_likelihood(x_pusher: Tensor, x_contact: Tensor, x_side: Tensor) -> Tensor:
        return likelihood(x_pusher.detach(), x_contact, x_side)  # stops p₁

    return likelihood if options.likelihood_path else fixed_likelihood
