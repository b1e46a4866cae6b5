"""The arm's estimators: joints, end effector, camera, the stick as a pusher, and its height."""

from dataclasses import dataclass

from torch import Tensor, nn

from aicon_torch.differentiation import stop
from aicon_torch.estimation import Deterministic, Estimator
from aicon_torch.interconnections import Interconnection
from aicon_torch.models.arm_push.options import REACTION
from aicon_torch.models.arm_push.scene import Scene
from aicon_torch.parts.camera import CameraFrame
from aicon_torch.parts.encoders import joint_filter
from aicon_torch.parts.end_effector import EndEffector, ToolPose
from aicon_torch.parts.recent import Recent
from aicon_torch.parts.self_collision import CapsuleSegments
from aicon_torch.parts.servo import even_motion
from aicon_torch.parts.touch import ContactForce
from aicon_torch.parts.velocity_lag import VelocityLag


def arm(scene: Scene) -> list[Estimator]:
    """Joints and end effector, the stick as pushT's pusher, and the shape of the arm."""
    options = scene.options

    # Where readings are late, what the joints made of their command has moved them; prompt ones
    # correct at every step what the lag did.
    middle = options.robot.chain.middle.tolist()
    velocity = "v_joints" if options.is_late else "a"
    lag = [VelocityLag(len(middle), REACTION)] if options.is_late else []

    # The way of the tip, from how the joints have moved.
    tip_motion = TipMotion(scene.end_effector, options.parts)
    motion = Interconnection(tip_motion, inputs=["x_joints", velocity, "dt"])

    estimators: list[Estimator] = [
        *lag,
        joint_filter(middle, velocity, options.delay),
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
