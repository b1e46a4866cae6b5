"""Pushing with an arm (Sect. "Real-World Transfer: Handling Additional Goal Conflicts").

The contact-based dynamics model is that of pushT. Added to it are the joints, the kinematics and the goals
of height, joint limits and self-collision. All gradients reach the joints through the kinematics.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn

from aicon_torch.control import Policy
from aicon_torch.estimation import EKF, Deterministic, Estimator, KalmanFilter, Measurement
from aicon_torch.goals import Goal
from aicon_torch.graph import WorldModel
from aicon_torch.interconnections import Affine, Interconnection
from aicon_torch.models.panda_push.goals import CertainPush, KeepHeight, StayUpright
from aicon_torch.models.panda_push.limits import ArmLimits
from aicon_torch.models.panda_push.measurements import (
    ObservedPose,
    SeenKeypoints,
    position_jacobian,
    seen_middle,
    seen_top,
    top_jacobian,
)
from aicon_torch.models.panda_push.options import Options
from aicon_torch.models.panda_push.perception import BLOB, KEYPOINTS, CameraPerception
from aicon_torch.parts.camera import CameraFrame, Visibility
from aicon_torch.parts.chain import Chain
from aicon_torch.parts.contact import closest_point
from aicon_torch.parts.contact_dynamics import ContactDynamics
from aicon_torch.parts.end_effector import EndEffector, ToolPose
from aicon_torch.parts.image_registration import ImageRegistration
from aicon_torch.parts.joint_limits import JointLimits
from aicon_torch.parts.pose import PoseDistance, PoseMotion, pose_jacobian
from aicon_torch.parts.rigid_object import RigidObject
from aicon_torch.parts.self_collision import CapsuleSegments, SelfCollision
from aicon_torch.parts.touch import ContactForce, TouchedSide, TouchedTop
from aicon_torch.parts.workspace import Workspace
from aicon_torch.quantities import Actuator, Sensor

JOINT_DRIFT = 1e-6
"""Variance of what turns a joint in a step besides its command, rad²."""

UNSEEN_DEVIATION = (0.1, 1 / 6, 2.0)
"""Standard deviation of the object's pose before it is seen, m, m and rad."""

UNSEEN_TOP_VARIANCE, TOP_DRIFT, TOP_NOISE = 1e-4, 1e-9, 1e-6
"""Variances of the height of the object's top: before it is seen, of its change in a step, and of a reading,
m²."""

OBSERVED_POSE_DEVIATION = 1 / 600
"""Standard deviation of the object's position before its pose is observed, m."""


@dataclass(frozen=True)
class Scene:
    """What the estimators of one graph share.

    Attributes:
        options: The options.
        body: The object.
        end_effector: The arm.
        dynamics: What a contact does to the object.
    """

    options: Options
    body: RigidObject
    end_effector: EndEffector
    dynamics: ContactDynamics

    @classmethod
    def of(cls, options: Options) -> "Scene":
        """The scene that the options describe."""
        body = RigidObject.of(options.corners)
        return cls(options, body, end_effector(options), options.contact.dynamics(body))

    @property
    def pose(self) -> ToolPose:
        """From the tool to x_ee and back."""
        return self.end_effector.pose


def end_effector(options: Options) -> EndEffector:
    """The arm from the joints to x_ee."""
    robot = options.robot
    chain = Chain(robot.frames, robot.tool)
    pose = ToolPose(robot.stick_length, options.lever)
    return EndEffector(chain, pose, options.pullback, options.damping)


def build(options: Options) -> Policy:
    """The arm's policy."""
    model = world_model(options)
    perception = camera_perception(options) if options.sensing == "camera" else None
    return Policy(model, options.resolution, options.law, perception=perception)


def camera_perception(options: Options) -> CameraPerception:
    """What turns the camera's images into readings."""
    robot = options.robot
    corners = np.array(options.corners, dtype=np.float64)
    registration = ImageRegistration(corners, robot.intrinsics)
    chain = Chain(robot.frames, robot.tool)
    return CameraPerception(registration, chain, robot.camera, options.camera.trust)


def world_model(options: Options) -> WorldModel:
    """The graph of the arm, of which that of pushT is a part."""
    scene = Scene.of(options)
    return WorldModel(
        sensors=_sensors(options),
        actuators={"a": _joints_actuator(scene)},
        estimators=[*_arm(scene), *_object(scene), *_contacts(scene)],
        goals=_goals(scene),
        dt=options.dt,
        dtype=options.dtype,
    )


def _sensors(options: Options) -> dict[str, Sensor]:
    """Encoders and target, and either the pose of the object or the camera and the wrist."""
    sensors = {
        "z_joints": Sensor(len(options.robot.frames), "rad", key="q"),
        "z_target": Sensor(3, "m, m, rad", key="target"),
    }
    if options.sensing == "pose":
        sensors["z_object"] = Sensor(3, "m, m, rad", key="object_pose", optional=True)
        return sensors

    sensors["z_ft"] = Sensor(6, "N, Nm", key="ft", range=(-100.0, 100.0))
    sensors[KEYPOINTS] = Sensor(3 * len(options.corners), "m", optional=True)
    sensors[BLOB] = Sensor(3, "m", optional=True)
    sensors["z_age"] = Sensor(1, "s", key="image_age")
    return sensors


def _joints_actuator(scene: Scene) -> Actuator:
    """The velocities of the joints, within their limits and those of the tip."""
    options = scene.options
    contact = None
    if options.contact_limits is not None:
        contact = options.contact_limits.limits(
            scene.dynamics, options.robot.stick_radius, options.contact.size
        )
    limits = ArmLimits(scene.end_effector, options.robot.speed, options.limits, contact)
    return Actuator(
        len(options.robot.frames), "rad/s", limit=options.limits.joint_speed, constraints=[limits]
    )


def _arm(scene: Scene) -> list[Estimator]:
    """Joints, end effector, the stick as pushT's pusher, its height, and the shape of the arm."""
    options, robot = scene.options, scene.options.robot
    estimators: list[Estimator] = [
        _joints(options),
        Deterministic("x_ee", scene.end_effector),
        Deterministic("x_pusher", planar_position),
        Deterministic("v_pusher", TipVelocity(scene.end_effector)),
    ]

    if options.sensing == "camera":
        mount, steering = robot.camera, options.camera.steering
        estimators += [
            Deterministic("x_cam", CameraFrame(scene.pose, mount, steering)),
            Deterministic("x_force", ContactForce(scene.pose, robot.tool_mass)),
            _object_top(options),
            Deterministic("x_heights", HeightOverTop(options.height)),
        ]
    else:
        estimators.append(Deterministic("x_heights", HeightOverTable(options.height)))

    if options.self_collision is not None:
        segments = CapsuleSegments(scene.end_effector.chain, robot.capsules)
        estimators.append(Deterministic("x_body", segments))
    return estimators


def _joints(options: Options) -> KalmanFilter:
    """x_joints: the encoders, filtered."""
    low, high = options.robot.low, options.robot.high
    middle = [(lower + upper) / 2 for lower, upper in zip(low, high, strict=True)]
    encoders = Affine(x_joints=1.0, z_joints=-1.0)
    return KalmanFilter(
        "x_joints",
        "P_joints",
        predict=Affine(x_joints=1.0, a=options.dt),
        noise=JOINT_DRIFT,
        initial=(middle, 10.0),
        correct=[Measurement(encoders, options.joint_noise**2, size=len(middle))],
    )


def planar_position(x_ee: Tensor) -> Tensor:
    """x_pusher: where the tip is in the plane, ``(*B, 2)``, m."""
    return x_ee[..., :2]


class TipVelocity(nn.Module):
    """v_pusher: how fast the last action moved the tip in the plane, ``(*B, 2)``, m/s.

    Args:
        end_effector: Of the arm.
    """

    def __init__(self, end_effector: EndEffector) -> None:
        super().__init__()
        self.end_effector = end_effector

    def forward(self, x_joints: Tensor, a: Tensor) -> Tensor:
        """The velocity; what moved the object is past, so no gradient leads to the next action."""
        jacobian = self.end_effector.jacobian(x_joints.detach())
        return (jacobian[..., :2, :] @ a.detach().unsqueeze(-1)).squeeze(-1)


@dataclass(frozen=True)
class HeightOverTable:
    """x_heights: height of the tip above where it should be, over a table at height 0.

    Attributes:
        height: Where it should be, m.
    """

    height: float

    def __call__(self, x_ee: Tensor) -> Tensor:
        """``(*B, 1)``, m."""
        return x_ee[..., 2:3] - self.height


@dataclass(frozen=True)
class HeightOverTop:
    """x_heights: height of the tip above where it should be, by so much below the object's top.

    Attributes:
        depth: By how much, m.
    """

    depth: float

    def __call__(self, x_ee: Tensor, x_top: Tensor) -> Tensor:
        """``(*B, 1)``, m."""
        return x_ee[..., 2:3] - x_top + self.depth


def _object_top(options: Options) -> EKF:
    """x_top: height of the object's top face, m, from the depth of its keypoints and by touch."""
    seen = Interconnection(seen_top, None, x_top=top_jacobian)
    correct = [Measurement(seen, TOP_NOISE, size=1)]
    if options.touch is not None:
        touched = TouchedTop(options.touch.top_deviation, options.touch.top)
        correct.append(Measurement(touched, touched.variance, size=1))

    return EKF(
        "x_top",
        "P_top",
        predict=Affine(x_top=1.0),
        noise=TOP_DRIFT,
        initial=((2 * options.height,), UNSEEN_TOP_VARIANCE),
        correct=correct,
    )


def _object(scene: Scene) -> list[Estimator]:
    """The object's pose, its keypoints there, and where it is to be."""
    pose = _seen_pose(scene) if scene.options.sensing == "camera" else _observed_pose(scene)
    keypoints = Interconnection(scene.body.keypoints_at, inputs=["x_pose"])
    target = Interconnection(scene.body.pose_of_frame, inputs=["z_target"])
    return [pose, Deterministic("x_keypoints", keypoints), Deterministic("x_target", target)]


def _seen_pose(scene: Scene) -> EKF:
    """x_pose as the camera shows it and the wrist feels it."""
    options, camera = scene.options, scene.options.camera
    by_position = camera.noise**2
    by_angle = by_position / scene.body.radius_of_gyration**2
    visibility = Visibility(
        options.robot.intrinsics,
        variances=(by_position, by_position, by_angle),
        edge_growth=camera.edge_growth,
        height=2 * options.height,
    )

    seen = Interconnection(SeenKeypoints(scene.body), None, x_pose=pose_jacobian)
    middle = Interconnection(seen_middle, None, x_pose=position_jacobian)
    correct = [
        Measurement(seen, visibility, size=3),
        Measurement(middle, camera.blob_noise**2, size=2),
    ]
    if options.touch is not None:
        radius, deviation = options.robot.stick_radius, options.touch.side_deviation
        touched = TouchedSide(scene.body, radius, deviation, options.touch.side)
        correct.append(Measurement(touched, touched.variance, size=1))

    variances = [deviation**2 for deviation in UNSEEN_DEVIATION]
    return _moving_pose(scene, initial=((*options.expected_place, 0.0), variances), correct=correct)


def _observed_pose(scene: Scene) -> EKF:
    """x_pose as it is observed."""
    by_position = scene.options.pose_noise**2
    by_angle = by_position / scene.body.radius_of_gyration**2
    observed = ObservedPose(scene.body, OBSERVED_POSE_DEVIATION)
    residual = Interconnection(observed, None, x_pose=pose_jacobian)

    reading = Measurement(residual, (by_position, by_position, by_angle), size=3)
    return _moving_pose(scene, initial=observed.prior, size=3, correct=[reading])


def _moving_pose(scene: Scene, **belief: Any) -> EKF:
    """x_pose, predicted from what the tip has pushed; how it begins and is corrected is given."""
    motion = PoseMotion(scene.dynamics, scene.options.robot.stick_radius)
    by_tip = ["x_pose", "x_pusher", "v_pusher", "dt"]

    by_position = scene.options.drift**2 * scene.options.dt
    by_angle = by_position / scene.body.radius_of_gyration**2
    return EKF(
        "x_pose",
        "P_pose",
        predict=Interconnection(motion, by_tip, x_pose=pose_jacobian),
        noise=(by_position, by_position, by_angle),
        **belief,
    )


def _contacts(scene: Scene) -> list[Estimator]:
    """The contact model, as in pushT: for each side where a contact may be, how likely, and what it does."""
    likelihood = scene.options.contact.likelihood(scene.options.robot.stick_radius)
    return [
        Deterministic("x_side", scene.body.sides),
        Deterministic("x_contact", closest_point, each=["x_side"]),
        Deterministic("p_contact", likelihood, each=["x_side", "x_contact"]),
        Deterministic("x_obj", scene.dynamics),
    ]


def _goals(scene: Scene) -> list[Goal]:
    """Pushing, and the goals of the arm that the options ask for; all costs are in m."""
    options, robot = scene.options, scene.options.robot
    goals = [Goal("push", _push(scene)), Goal("height", KeepHeight(options.height_tolerance))]

    if options.upright_tolerance is not None:
        goals.append(Goal("upright", StayUpright(options.lever, options.upright_tolerance)))
    if options.workspace is not None:
        goals.append(Goal("workspace", Workspace(robot.reach, options.workspace)))
    if options.joint_limits is not None:
        limits = JointLimits(robot.low, robot.high, options.joint_limits)
        goals.append(Goal("joint_limits", limits))
    if options.self_collision is not None:
        collision = SelfCollision(robot.capsules, options.self_collision)
        goals.append(Goal("self_collision", collision))
    return goals


def _push(scene: Scene) -> Callable[..., Tensor]:
    """g₁, with the uncertainty of an object that is seen."""
    length, camera = scene.dynamics.rotation_length, scene.options.camera
    if scene.options.sensing == "camera" and camera.trace_weight > 0:
        return CertainPush(length, camera.trace_weight, camera.trace_tolerance)
    return PoseDistance(length)
