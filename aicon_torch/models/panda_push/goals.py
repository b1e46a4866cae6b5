"""The goals of pushing with an arm that have no part of their own."""

from dataclasses import dataclass

from torch import Tensor

from aicon_torch.parts.planar import norm, pose_error


def dead_zone(cost: Tensor, tolerance: float) -> Tensor:
    """max(0, cost − tolerance), ``(*B,)``: within the tolerance a goal asks for nothing."""
    return (cost - tolerance).clamp(min=0.0)


@dataclass(frozen=True)
class CertainPush:
    """g₁ = ‖x_obj − x_target‖ + w max(0, tr Σ − ε), the angle counting as a length L.

    Attributes:
        rotation_length: L, m: a rotation by one rad counts as much as a translation by L.
        weight: w, 1/m.
        tolerance: ε, m²; 0 in the text.
    """

    rotation_length: float
    weight: float
    tolerance: float

    def __call__(self, x_obj: Tensor, x_target: Tensor, P_pose: Tensor) -> Tensor:
        """The cost ``(*B,)``, m.

        Args:
            x_obj: The object's pose, ``(*B, 3)``, m and rad.
            x_target: Its target, likewise.
            P_pose: Covariance of the pose, ``(*B, 3, 3)``.
        """
        x, y, angle = P_pose.diagonal(dim1=-2, dim2=-1).unbind(-1)
        trace = x + y + self.rotation_length**2 * angle

        distance = norm(pose_error(x_obj, x_target, self.rotation_length))
        return distance + self.weight * dead_zone(trace, self.tolerance)


@dataclass(frozen=True)
class KeepHeight:
    """g₂ = max(0, ‖x_heights‖ − ε).

    Attributes:
        tolerance: ε, m; 0 in the text.
    """

    tolerance: float

    def __call__(self, x_heights: Tensor) -> Tensor:
        """The cost ``(*B,)``, m, of a deviation from the height ``(*B, 1)``, m."""
        return dead_zone(norm(x_heights), self.tolerance)


@dataclass(frozen=True)
class StayUpright:
    """g = L max(0, ‖tilt‖ − ε), where the tilt of the stick is the sine of its angle.

    Attributes:
        lever: L, the lever of x_ee, m.
        tolerance: ε, rad.
    """

    lever: float
    tolerance: float

    def __call__(self, x_ee: Tensor) -> Tensor:
        """The cost ``(*B,)``, m, of an end effector ``(*B, 6)``."""
        tilt = x_ee[..., 3:5]  # as a length: see :class:`aicon_torch.parts.end_effector.ToolPose`
        return dead_zone(norm(tilt), self.lever * self.tolerance)
