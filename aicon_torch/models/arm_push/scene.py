"""What the estimators of one graph share: options, object, arm, and what a push does."""

import copy
from dataclasses import dataclass

from aicon_torch.models.arm_push.options import Options
from aicon_torch.parts.contact_dynamics import ContactDynamics
from aicon_torch.parts.end_effector import EndEffector, ToolPose
from aicon_torch.parts.rigid_object import RigidObject


@dataclass(frozen=True)
class Scene:
    """The parts that several estimators use. Build one with :meth:`of`.

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


def end_effector(options: Options) -> EndEffector:
    """The arm, from the joints to x_ee."""
    robot = options.robot
    pose = ToolPose(robot.stick_length, options.lever)

    # A chain of its own, which the model takes into its precision and onto its device.
    return EndEffector(copy.deepcopy(robot.chain), pose, options.pullback, options.damping)
