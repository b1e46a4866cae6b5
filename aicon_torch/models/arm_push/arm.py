"""The arm's estimators: joints, end effector, camera, the stick as a pusher, and its height."""

from dataclasses import dataclass
from typing import Any

from torch import Tensor, nn

from aicon_torch.differentiation import stop
from aicon_torch.estimation import (
    EKF,
    Deterministic,
    Estimator,
    KalmanFilter,
    LateEKF,
    Measurement,
)
from aicon_torch.interconnections import Affine, Interconnection
from aicon_torch.models.arm_push.options import REACTION, Options
from aicon_torch.models.arm_push.scene import Scene
from aicon_torch.parts.camera import CameraFrame
from aicon_torch.parts.end_effector import EndEffector, ToolPose
from aicon_torch.parts.recent import Recent
from aicon_torch.parts.self_collision import CapsuleSegments
from aicon_torch.parts.servo import even_motion
from aicon_torch.parts.touch import ContactForce
from aicon_torch.parts.velocity_lag import VelocityLag

JOINT_NOISE = 1e-4
"""Standard deviation of an encoder, rad."""

JOINT_DRIFT = 1e-6
"""Variance of what turns a joint in a step besides its command, rad²."""

UNKNOWN_JOINT = 10.0
"""Variance of a joint's angle before it is read, rad²."""


def arm(scene: Scene) -> list[Estimator]:
    """Joints and end effector, the stick as pushT's pusher, and the shape of the arm."""
    options = scene.options

    # The way of the tip, from how the joints have moved.
    tip_motion = TipMotion(scene.end_effector, options.parts)
    motion = Interconnection(tip_motion, inputs=["x_joints", moved_by(options), "dt"])

    estimators: list[Estimator] = [
        *lag(options),
        joints(options),
        Deterministic("x_ee", scene.end_effector),
        Deterministic("x_pusher", planar_position),
        Deterministic("d_pusher", motion),
    ]
    if options.self_collision is not None:
        segments = CapsuleSegments(scene.end_effector.chain, options.robot.shape.capsules)
        estimators.append(Deterministic("x_body", segments))
    return estimators


def hand(scene: Scene) -> list[Estimator]:
    """The camera in the hand, and the force at the wrist."""
    robot = scene.options.robot
    pose = ToolPose(robot.stick_length, scene.options.lever)
    camera = CameraFrame(pose, robot.camera, scene.options.camera.steering)
    force = ContactForce(pose, robot.tool_mass)
    estimators: list[Estimator] = [
        Deterministic("x_cam", camera),
        Deterministic("x_force", force),
    ]

    # Where the camera was when a late image was taken.
    delay = scene.options.camera.delay
    if delay:
        estimators.append(Recent("z_joints", delay))
    return estimators


def lag(options: Options) -> list[Estimator]:
    """v_joints, where readings are late: prompt ones correct at every step what a lag did."""
    return [VelocityLag(len(options.robot.chain.names), REACTION)] if options.is_late else []


def moved_by(options: Options) -> str:
    """What has moved the joints: their command, or where readings are late what they made of it."""
    return "v_joints" if options.is_late else "a"


def joints(options: Options) -> EKF:
    """x_joints: the encoders, filtered."""
    velocity = moved_by(options)

    # Until they are read, joints are next to unknown, about the middle of their ranges.
    middle = options.robot.chain.middle.tolist()
    agreement = Affine(x_joints=1.0, z_joints=-1.0)
    belief: dict[str, Any] = {
        "predict": Affine(x_joints=1.0, **{velocity: "dt"}),
        "noise": JOINT_DRIFT,
        "initial": (middle, UNKNOWN_JOINT),
        "correct": [Measurement(agreement, JOINT_NOISE**2, size=len(middle))],
    }

    # Encoders that are late correct where the joints were when they were read.
    if not options.delay:
        return KalmanFilter("x_joints", "P_joints", **belief)
    moved = {velocity: len(middle), "dt": 1}
    late: dict[str, Any] = {"sensor": "z_joints", "steps": options.delay, "moved_by": moved}
    return LateEKF("x_joints", "P_joints", **late, **belief)


def planar_position(x_ee: Tensor) -> Tensor:
    """x_pusher: where the tip is in the plane, ``(*B, 2)``, m."""
    return x_ee[..., :2]


class TipMotion(nn.Module):
    """d_pusher: the way of the tip in the plane through the last step, ``(*B, 2n)``, m.

    They are its displacements after each of n equal parts of an even motion.

    Args:
        end_effector: Of the arm.
        parts: n.
    """

    def __init__(self, end_effector: EndEffector, parts: int) -> None:
        super().__init__()
        self.end_effector, self.parts = end_effector, parts

    def forward(self, x_joints: Tensor, velocity: Tensor, dt: Tensor) -> Tensor:
        """The motion at the joint angles ``(*B, n)``, rad, by their velocity ``(*B, n)``, rad/s."""
        # What moved the object is past, so no gradient leads to the next action.
        jacobian = self.end_effector.jacobian(stop(x_joints))
        tip: Tensor = (jacobian @ stop(velocity).unsqueeze(-1)).squeeze(-1)
        return even_motion(tip[..., :2] * dt, self.parts)


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
class HeightAtObject:
    """x_heights: height of the tip above where it should be, so far below the object's top.

    Attributes:
        depth: How far, m.
    """

    depth: float

    def __call__(self, x_ee: Tensor, x_top: Tensor) -> Tensor:
        """``(*B, 1)``, m."""
        return x_ee[..., 2:3] - x_top + self.depth
