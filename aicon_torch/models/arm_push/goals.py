"""The goals of pushing with an arm that have no part of their own."""

from dataclasses import dataclass

import torch
from torch import Tensor

from aicon_torch.errors import OptionError
from aicon_torch.models.arm_push.robot import PushingRobot
from aicon_torch.parts.hinge import SquaredHinge
from aicon_torch.parts.planar import norm, pose_error
from aicon_torch.parts.rigid_object import RigidObject


@dataclass(frozen=True)
class Ring:
    """g = w Σ max(0, 1 − m/m₀)², where m are the distances to the edges of a ring about the base.

    Where the centre of an object is within the ring, the tip gets behind it from all sides; what is
    pushed beyond cannot be pushed back. Build one with :meth:`within_reach`.

    Attributes:
        edges: Least and largest distance of the centre from the axis of the base, m.
        cost: Margin m₀ (m) and weight w (m).
    """

    edges: tuple[float, float]
    cost: SquaredHinge

    @classmethod
    def within_reach(cls, robot: PushingRobot, body: RigidObject, cost: SquaredHinge) -> "Ring":
        """The ring of an object around which the stick of a robot gets.

        Its edges are where the tip gets to, less the farthest corner of the object and the radius
        of the stick.

        Raises:
            OptionError: If the object is too large for any.
        """
        # On either side of the object the stick has to get around its farthest corner.
        around = body.radius + robot.stick_radius
        nearest, farthest = robot.nearest + around, robot.reach - around
        if not nearest < farthest:
            raise OptionError(
                f"The stick reaches from {robot.nearest} to {robot.reach} m, and gets nowhere "
                f"around an object whose corners are {body.radius:.3f} m from its centre: expected "
                "a smaller object, a robot with more reach, or ring=None."
            )
        return cls((nearest, farthest), cost)

    def __call__(self, x_obj: Tensor) -> Tensor:
        """The cost ``(*B,)``, m, of a pose ``(*B, 3)``, m and rad."""
        nearest, farthest = self.edges
        distance = norm(x_obj[..., :2])
        return self.cost(torch.stack((distance - nearest, farthest - distance), dim=-1))


@dataclass(frozen=True)
class PushWithinReach:
    """g₁ = ‖x_obj − x_target‖ + the cost of leaving a ring, the angle counting as a length L.

    Attributes:
        rotation_length: L, m: a rotation by one rad counts as much as a translation by L.
        ring: Where the object is to stay.
    """

    rotation_length: float
    ring: Ring

    def __call__(self, x_obj: Tensor, x_target: Tensor) -> Tensor:
        """The cost ``(*B,)``, m, of two poses ``(*B, 3)``, m and rad."""
        return norm(pose_error(x_obj, x_target, self.rotation_length)) + self.ring(x_obj)


@dataclass(frozen=True)
class CertainPush:
    """g₁ = ‖x_obj − x_target‖ + w max(0, tr Σ − ε), the angle counting as a length L.

    Attributes:
        rotation_length: L, m: a rotation by one rad counts as much as a translation by L.
        weight: w, 1/m.
        tolerance: ε, m²; 0 in the text.
        ring: Where the object is to stay, if anywhere; not in the text.
    """

    rotation_length: float
    weight: float
    tolerance: float
    ring: Ring | None = None

    def __call__(self, x_obj: Tensor, x_target: Tensor, P_pose: Tensor) -> Tensor:
        """The cost ``(*B,)``, m.

        Args:
            x_obj: The object's pose, ``(*B, 3)``, m and rad.
            x_target: Its target, likewise.
            P_pose: Covariance of the pose, ``(*B, 3, 3)``.
        """
        # tr Σ, with the angle as a length.
        x, y, angle = P_pose.diagonal(dim1=-2, dim2=-1).unbind(-1)
        trace = x + y + self.rotation_length**2 * angle

        distance = norm(pose_error(x_obj, x_target, self.rotation_length))
        uncertain = distance + self.weight * (trace - self.tolerance).clamp(min=0.0)
        return uncertain if self.ring is None else uncertain + self.ring(x_obj)


def off_height(x_heights: Tensor) -> Tensor:
    """g₂ = ‖x_heights‖ ``(*B,)``, m, of a deviation from the height ``(*B, 1)``, m."""
    return norm(x_heights)


def tilt(x_ee: Tensor) -> Tensor:
    """L ‖tilt‖ ``(*B,)``, m, of an end effector ``(*B, 6)``: the sine of the stick's angle.

    It is a length already: see :class:`aicon_torch.parts.end_effector.ToolPose`.
    """
    return norm(x_ee[..., 3:5])
