"""The arm's estimators: joints, end effector, camera, the stick as a pusher, and its height.

Its servos follow with a lag, so what was commanded goes on. Where things are now has the letter y
(y_joints, y_ee, …), where the commands given so far take them the letter x: readings speak of the
first, goals of the second.
"""
from dataclasses import dataclass

from torch import Tensor, nn

from aicon_torch.estimation import Deterministic, Estimator, KalmanFilter, Measurement
from aicon_torch.interconnections import Affine, Interconnection
from aicon_torch.models.panda_push.options import Options
from aicon_torch.models.panda_push.scene import Scene
from aicon_torch.parts.camera import CameraFrame
from aicon_torch.parts.end_effector import EndEffector
from aicon_torch.parts.self_collision import CapsuleSegments
from aicon_torch.parts.servo import LaggingMotion, even_motion
from aicon_torch.parts.touch import ContactForce
from aicon_torch.shaping import straight_through

JOINT_DRIFT = 1e-6
"""Variance of what turns a joint in a step besides its command, rad²."""

UNKNOWN_JOINT = 10.0
"""Variance of a joint's angle before it is read, rad²."""


def arm(scene: Scene) -> list[Estimator]:
    """Joints and end effector, the stick as pushT's pusher, and the shape of the arm."""
    end_effector = scene.end_effector
    here = Interconnection(end_effector, inputs=["y_joints"])
    pusher_here = Interconnection(planar_position, inputs=["y_ee"])

    estimators: list[Estimator] = [
        LaggingMotion(scene.options.robot.servo_time, len(scene.options.robot.frames)),
        joints(scene.options),
        Deterministic("x_joints", commanded_joints),
        Deterministic("y_ee", here),
        Deterministic("x_ee", end_effector),
        Deterministic("y_pusher", pusher_here),
        Deterministic("x_pusher", planar_position),
        Deterministic("d_pusher", TipMotion(end_effector)),
    ]
    if scene.options.self_collision is not None:
        segments = CapsuleSegments(scene.end_effector.chain, scene.options.robot.capsules)
        estimators.append(Deterministic("x_body", segments))
    return estimators


def hand(scene: Scene) -> list[Estimator]:
    """The camera in the hand, and the force at the wrist."""
    robot, pose = scene.options.robot, scene.end_effector.pose
    camera = CameraFrame(pose, robot.camera, scene.options.camera.steering)
    force = ContactForce(pose, robot.tool_mass)
    return [
        Deterministic("y_cam", Interconnection(camera, inputs=["y_ee"])),
        Deterministic("x_cam", camera),
        Deterministic("x_force", Interconnection(force, inputs=["z_ft", "y_ee"])),
    ]


def joints(options: Options) -> KalmanFilter:
    """y_joints: the encoders, filtered."""
    low, high = options.robot.low, options.robot.high
    middle = [(lower + upper) / 2 for lower, upper in zip(low, high, strict=True)]
    agreement = Affine(y_joints=1.0, z_joints=-1.0)
    return KalmanFilter(
        "y_joints",
        "P_joints",
        predict=Affine(y_joints=1.0, d_joints=1.0),
        noise=JOINT_DRIFT,
        initial=(middle, UNKNOWN_JOINT),
        correct=[Measurement(agreement, options.joint_noise**2, size=len(middle))],
    )


def commanded_joints(y_joints: Tensor, x_lag: Tensor, a: Tensor, dt: float) -> Tensor:
    """x_joints: where the commands so far take the joints.

    Args:
        y_joints: Where they are, ``(*B, n)``, rad.
        x_lag: By how much they lag behind, ``(*B, n)``, rad.
        a: The next command, which takes them a·dt further, ``(*B, n)``, rad/s.
        dt: Time step, s.

    Returns:
        ``(*B, n)``, rad.
    """
    commanded = (y_joints + x_lag).detach()  # what was commanded is past
    return straight_through(commanded, a * dt)


def planar_position(x_ee: Tensor) -> Tensor:
    """x_pusher: where the tip is in the plane, ``(*B, 2)``, m."""
    return x_ee[..., :2]


class TipMotion(nn.Module):
    """d_pusher: the tip's way through the last step in the plane, ``(*B, 2n)``, m.

    Args:
        end_effector: Of the arm.
    """

    def __init__(self, end_effector: EndEffector) -> None:
        super().__init__()
        self.end_effector = end_effector

    def forward(self, y_joints: Tensor, d_joints: Tensor) -> Tensor:
        """The way of joints that have moved by d_joints to y_joints, ``(*B, n)``, rad."""
        # What moved the object is past, so no gradient leads to the next action.
        jacobian = self.end_effector.jacobian(y_joints.detach())
        motion: Tensor = (jacobian @ d_joints.detach().unsqueeze(-1)).squeeze(-1)
        return even_motion(motion[..., :2])


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
