"""The pose of any tip as lengths: where it is and, if that matters, how it is turned."""

import math
from dataclasses import dataclass
from typing import Literal, get_args

import torch
from torch import Tensor

from aicon_torch.errors import OptionError
from aicon_torch.parts.axis import check_axis
from aicon_torch.parts.planar import norm
from aicon_torch.quantities import as_number
from aicon_torch.validation import check_choice

Orientation = Literal["free", "axis", "full"]
"""How much of a tip's orientation matters: nothing, one of its axes, or all."""


@dataclass(frozen=True)
class TipPose:
    """x_ee: the position p of a tip and, as lengths, its orientation; k = 3, 6 or 12.

    - ``"free"``: p.
    - ``"axis"``: p and L·a, where a is one axis of the tip: an approach direction.
    - ``"full"``: p and (L/√2)·R, where R is the rotation matrix, column by column.

    In each of them a turn by δ rad is a motion by L·δ, so that gradients of positions and of angles
    can be compared, and the least-squares motion of the joints weighs both alike.

    Attributes:
        orientation: How much of the orientation matters.
        lever: L: a rotation by one rad counts as much as a motion by this, m.
        axis: The axis that matters, a unit vector in the frame of the tip; of a whole orientation
            that of the tool, along which it approaches.

    Raises:
        OptionError: If there is no such orientation, or the lever or the axis has no length.

    Example:
        >>> end_effector = EndEffector(chain, TipPose("full", lever=0.2), damping=0.05)
        >>> position = end_effector(q)[..., :3]
    """

    orientation: Orientation = "full"
    lever: float = 0.2
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)

    def __post_init__(self) -> None:
        """Check the options."""
        check_choice(self, "orientation", get_args(Orientation))
        if not as_number(self.lever) > 0:
            raise OptionError(f"lever={self.lever!r}: expected a length > 0 (m).")
        check_axis("axis", self.axis)

    @property
    def size(self) -> int:
        """k, the number of lengths."""
        return {"free": 3, "axis": 6, "full": 12}[self.orientation]

    def of_frame(self, tool: Tensor) -> Tensor:
        """x_ee ``(*B, k)``, m, of the tip's transform ``(*B, 4, 4)``."""
        position = self.point(tool)
        if self.orientation == "free":
            return position
        return torch.cat((position, self._directions(tool).flatten(-2)), dim=-1)

    def point(self, tool: Tensor) -> Tensor:
        """The position of the tip, ``(*B, 3)``, m."""
        return tool[..., :3, 3]

    def jacobian(self, tool: Tensor, geometric: Tensor) -> Tensor:
        """∂x_ee/∂q ``(*B, k, n)``, from the geometric Jacobian of the tip, ``(*B, 6, n)``."""
        motion, turning = torch.split(geometric, 3, dim=-2)
        if self.orientation == "free":
            return motion

        # A turn about an axis moves a direction by axis × direction.
        directions = self._directions(tool).unsqueeze(-1)
        axes = turning.unsqueeze(-3)
        turned = torch.linalg.cross(axes, directions, dim=-2)
        return torch.cat((motion, turned.flatten(-3, -2)), dim=-2)

    def target(self, position: Tensor, orientation: Tensor | None = None) -> Tensor:
        """The x_ee of a target.

        Args:
            position: ``(*B, 3)``, m.
            orientation: The direction of the axis, ``(*B, 3)``, or a unit quaternion (w, x, y, z),
                ``(*B, 4)``; neither need be normalised. None where it is free.

        Returns:
            ``(*B, k)``, m.

        Raises:
            OptionError: If the orientation has another number of components.
        """
        if self.orientation == "free":
            return position

        count = {"axis": 3, "full": 4}[self.orientation]
        if orientation is None or orientation.shape[-1] != count:
            raise OptionError(
                f"orientation: got {None if orientation is None else orientation.shape[-1]} "
                f"numbers; expected {count} where {self.orientation!r} matters."
            )

        if self.orientation == "axis":
            length = torch.linalg.vector_norm(orientation, dim=-1, keepdim=True)
            return torch.cat((position, self.lever * orientation / length), dim=-1)

        columns = rotation_of_quaternion(orientation).mT
        return torch.cat((position, self._scale * columns.flatten(-2)), dim=-1)

    def distance(self, x_ee: Tensor, target: Tensor) -> tuple[Tensor, Tensor]:
        """How far a pose is from another: the distance of the positions, and the angle.

        Args:
            x_ee: The pose, ``(*B, k)``, m.
            target: The other one, ``(*B, k)``, m.

        Returns:
            ``(*B,)``, m, and ``(*B,)`` in [0, π], rad; 0 where the orientation is free.
        """
        offset = x_ee[..., :3] - target[..., :3]
        distance = norm(offset)
        if self.orientation == "free":
            return distance, torch.zeros_like(distance)

        turned, wanted = x_ee[..., 3:] / self._scale, target[..., 3:] / self._scale
        if self.orientation == "axis":
            return distance, _angle_of_directions(turned, wanted)
        return distance, _angle_of_rotations(turned, wanted)

    def axis_of(self, x_ee: Tensor) -> Tensor:
        """The axis that the tip has there, a direction ``(*B, 3)``; it must not be free."""
        directions = x_ee[..., 3:] / self._scale
        if self.orientation == "axis":
            return directions
        columns = directions.reshape(*directions.shape[:-1], 3, 3)
        return (columns.new_tensor(self.axis).unsqueeze(-1) * columns).sum(-2)

    @property
    def _scale(self) -> float:
        """The length of each direction, m: ‖d(sR)‖ = s√2 δ for a turn by δ."""
        return self.lever if self.orientation == "axis" else self.lever / math.sqrt(2.0)

    def _directions(self, tool: Tensor) -> Tensor:
        """The directions that matter as lengths: the axis ``(*B, 1, 3)`` or all ``(*B, 3, 3)``."""
        columns = tool[..., :3, :3].mT
        if self.orientation == "full":
            return self._scale * columns

        axis = columns.new_tensor(self.axis).unsqueeze(-2)
        return self._scale * (axis @ columns)


def rotation_of_quaternion(quaternion: Tensor) -> Tensor:
    """The rotation matrix ``(*B, 3, 3)`` of a quaternion (w, x, y, z) ``(*B, 4)`` of any length."""
    length = torch.linalg.vector_norm(quaternion, dim=-1, keepdim=True)
    w, x, y, z = (quaternion / length).unbind(-1)

    rows = (
        torch.stack((1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)), dim=-1),
        torch.stack((2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)), dim=-1),
        torch.stack((2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)), dim=-1),
    )
    return torch.stack(rows, dim=-2)


def _angle_of_directions(first: Tensor, second: Tensor) -> Tensor:
    """The angle ``(*B,)`` between unit vectors ``(*B, 3)``, rad."""
    sine = norm(torch.linalg.cross(first, second))
    return torch.atan2(sine, (first * second).sum(-1))


def _angle_of_rotations(first: Tensor, second: Tensor) -> Tensor:
    """The angle ``(*B,)`` of R₁R₂ᵀ, rad, for rotations as columns one after the other, ``(*B, 9)``.

    ‖vee(R − Rᵀ)‖ = 2 sin θ and tr R = 1 + 2 cos θ. The columns' cross products sum up to the former
    (R₁R₂ᵀ = Σ aᵢbᵢᵀ), their scalar products to the latter.
    """
    columns = first.reshape(*first.shape[:-1], 3, 3)
    others = second.reshape(*second.shape[:-1], 3, 3)
    doubled_sine = norm(torch.linalg.cross(columns, others).sum(-2))
    return torch.atan2(doubled_sine, (first * second).sum(-1) - 1.0)
