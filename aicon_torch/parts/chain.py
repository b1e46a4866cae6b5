"""A serial chain of joints: where its links are, and how they move with the joints."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import torch
from torch import Tensor, nn

from aicon_torch.errors import OptionError, choices
from aicon_torch.parts.axis import check_axis
from aicon_torch.parts.descriptions import JointDescription, read_mjcf, read_urdf
from aicon_torch.parts.joint_product import JointProduct, Transform
from aicon_torch.parts.library_chain import library_kinematics

LARGEST_DIFFERENCE = 1e-11
"""From pytorch-kinematics, relative to the size of the robot; rounding is some 1e-15."""


class Joint(NamedTuple):
    """A joint with one degree of freedom q, in rad where it turns and in m where it slides.

    Attributes:
        name: Its name.
        axis: What it turns about or slides along, a unit vector in the frame of its link.
        slides: Whether it is prismatic.
        low: The lowest q.
        high: The highest q.
        speed: The largest |dq/dt|.
    """

    name: str
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    slides: bool = False
    low: float = -math.inf
    high: float = math.inf
    speed: float = math.inf


class Chain(nn.Module):
    """A serial chain of n joints that turn about, or slide along, any axis.

    Link i is at Tᵢ = Tᵢ₋₁ Fᵢ Mᵢ(qᵢ) in the frame of the base (T₀ = I), where Fᵢ is fixed and Mᵢ(q)
    the motion of the joint, and the tip, which is fixed to the last link, at Tₙ F_tool.
    :meth:`from_urdf` and :meth:`from_mjcf` read a robot from its description.

    The frames come from a product in closed form. pytorch-kinematics, which is ten times as slow,
    loads every robot that is read as well, and both are compared when the chain is built.

    Args:
        fixed: Fᵢ for each of the n joints.
        tool: F_tool.
        joints: What is known of the joints; by default they turn about z without limits.

    Raises:
        OptionError: If there is no joint, or not one for each transform; if a transform has not 3
            or 4 rows of 4 numbers, an axis is no unit vector, or a lower limit not below the upper.

    Attributes:
        names: The names of the n joints.
        low: The lowest q, ``(n,)``, rad or m; −∞ where there is no limit.
        high: The highest q; ∞ where there is no limit.
        speed: The largest |dq/dt|, rad/s or m/s; ∞ where there is no limit.

    Example:
        >>> chain = Chain.from_urdf("ur5.urdf", tip="tool0")
        >>> position = chain(q)[..., :3, 3]
    """

    low: Tensor
    high: Tensor
    speed: Tensor
    axes: Tensor
    turns: Tensor

    def __init__(
        self, fixed: Sequence[Transform], tool: Transform, joints: Sequence[Joint] | None = None
    ) -> None:
        super().__init__()
        if joints is None:
            joints = [Joint(f"joint_{number}") for number in range(1, len(fixed) + 1)]
        if len(joints) != len(fixed):
            raise OptionError(f"joints has {len(joints)} of them: expected {len(fixed)}, as fixed.")
        if not fixed:
            raise OptionError("fixed: got no transform; expected one for each joint.")
        for joint in joints:
            check_axis(f"Joint {joint.name!r}: axis", joint.axis)
            if not joint.low < joint.high:
                raise OptionError(
                    f"Joint {joint.name!r}: low={joint.low!r}, high={joint.high!r}: expected lower "
                    "below upper."
                )

        names, axes, slides, low, high, speed = zip(*joints, strict=True)
        self.names: tuple[str, ...] = names
        self.product = JointProduct(fixed, tool, axes, slides)

        # As exact as it was read; whoever uses it takes it in the precision of the angles.
        for name, values in (("low", low), ("high", high), ("speed", speed), ("axes", axes)):
            self.register_buffer(name, torch.tensor(values, dtype=torch.float64))
        self.register_buffer("turns", ~torch.tensor(slides).unsqueeze(-1))

    @classmethod
    def from_urdf(
        cls, source: str | Path, tip: str | None = None, base: str | None = None
    ) -> "Chain":
        """The chain of a robot that a URDF describes.

        Args:
            source: A file, or the text of one.
            tip: The link at the end; may be left out if the robot does not branch and has no
                gripper.
            base: The link in whose frame everything is; the root by default.

        Raises:
            ModuleNotFoundError: If pytorch-kinematics is missing.
            OptionError: If the description is none, there are no such links, or a joint between
                them mimics another one or has more than one degree of freedom.
        """
        return cls.from_path(read_urdf(source).path(tip, base))

    @classmethod
    def from_mjcf(
        cls, source: str | Path, tip: str | None = None, base: str | None = None
    ) -> "Chain":
        """The chain of a model of MuJoCo's: links are bodies, and ``tip`` may be a site.

        Args and errors are those of :meth:`from_urdf`; MJCF has no limits of speed.
        """
        return cls.from_path(read_mjcf(source).path(tip, base))

    @classmethod
    def from_path(cls, path: Sequence[JointDescription]) -> "Chain":
        """The chain of the joints between two links of a robot that was read.

        Raises:
            ArithmeticError: If pytorch-kinematics finds another one.
            ModuleNotFoundError: If it is missing.
        """
        fixed, tool = _merge_fixed_joints(path)
        chain = cls(fixed, tool, [_joint(joint) for joint in path if joint.moves])
        _check_equal(chain, path)
        return chain

    @property
    def middle(self) -> Tensor:
        """The q halfway between its limits, ``(n,)``."""
        return (self.low + self.high) / 2

    def postures(self, count: int) -> Tensor:
        """Random postures within the limits, ``(count, n)``, rad or m; always the same ones.

        Joints without limits turn within ±π, or slide within ±1 m.
        """
        widest = torch.where(self.turns.squeeze(-1), torch.pi, 1.0).to(self.low)
        low = torch.where(self.low.isfinite(), self.low, -widest)
        high = torch.where(self.high.isfinite(), self.high, widest)

        generator = torch.Generator().manual_seed(0)
        share = torch.rand(count, len(self.names), generator=generator, dtype=torch.float64)
        return low + share.to(low) * (high - low)

    def forward(self, x_joints: Tensor) -> Tensor:
        """The transform of the tip, ``(*B, 4, 4)``, m, at q ``(*B, n)``, rad or m."""
        return self.frames(x_joints)[..., -1, :, :]

    def frames(self, x_joints: Tensor) -> Tensor:
        """Transforms of the n links and, last, of the tip.

        Args:
            x_joints: q, ``(*B, n)``, rad or m.

        Returns:
            ``(*B, n + 1, 4, 4)`` in the frame of the base, m.
        """
        frames: Tensor = self.product(x_joints)
        return frames

    def jacobian(self, x_joints: Tensor) -> Tensor:
        """The geometric Jacobian at the tip, in the frame of the base.

        Args:
            x_joints: q, ``(*B, n)``, rad or m.

        Returns:
            J, ``(*B, 6, n)``: J q̇ is the velocity of the tip (m/s) above its angular velocity
            (rad/s).
        """
        frames = self.frames(x_joints)
        return self.jacobian_at(frames, frames[..., -1, :3, 3])

    def jacobian_at(self, frames: Tensor, point: Tensor) -> Tensor:
        """The geometric Jacobian of a point that moves with the last link.

        A joint that turns about a, through o, moves it by a × (p − o) per rad; one that slides
        along a moves it by a.

        Args:
            frames: What :meth:`frames` returned, ``(*B, n + 1, 4, 4)``.
            point: p, ``(*B, 3)``, in the frame of the base, m.

        Returns:
            ``(*B, 6, n)``.
        """
        axes = self._axes(frames)
        angular = torch.where(self.turns.to(frames.device), axes, 0.0)
        return torch.cat((self._linear(frames, axes, point), angular.mT), dim=-2)

    def point_jacobian_at(self, frames: Tensor, point: Tensor) -> Tensor:
        """How each joint moves a point: the upper half of :meth:`jacobian_at`, ``(*B, 3, n)``."""
        return self._linear(frames, self._axes(frames), point)

    def _linear(self, frames: Tensor, axes: Tensor, point: Tensor) -> Tensor:
        """The same, where the axes ``(*B, n, 3)`` are known."""
        turned = torch.linalg.cross(axes, point.unsqueeze(-2) - frames[..., :-1, :3, 3])
        linear: Tensor = torch.where(self.turns.to(frames.device), turned, axes)
        return linear.mT

    def _axes(self, frames: Tensor) -> Tensor:
        """The axes of the joints, ``(*B, n, 3)``, in the frame of the base."""
        return (frames[..., :-1, :3, :3] @ self.axes.to(frames).unsqueeze(-1)).squeeze(-1)


def _joint(described: JointDescription) -> Joint:
    """What a chain keeps of a joint."""
    x, y, z = described.axis.tolist()
    slides = described.kind == "prismatic"
    limits = (described.low, described.high, described.speed)
    return Joint(described.name, (x, y, z), slides, *limits)


def _merge_fixed_joints(path: Sequence[JointDescription]) -> tuple[list[Transform], Transform]:
    """Fᵢ before each joint that moves, and what remains after the last."""
    fixed: list[Transform] = []

    # What fixed joints add up to belongs to the next joint that moves, or to the tool.
    transform = np.eye(4)

    for joint in path:
        transform = transform @ joint.fixed
        if joint.moves:
            fixed.append(transform.tolist())
            transform = np.eye(4)

    return fixed, transform.tolist()


def _check_equal(chain: Chain, path: Sequence[JointDescription]) -> None:
    """Compare the closed form with pytorch-kinematics at several postures.

    Raises:
        ArithmeticError: If they differ.
    """
    # Always the same postures, limits aside: a robot that was read once is read ever after.
    generator = torch.Generator().manual_seed(0)
    q = 3.0 * torch.randn(8, len(chain.names), generator=generator, dtype=torch.float64)
    frames, jacobian = library_kinematics(path, q)
    difference = torch.maximum(
        (chain.frames(q) - frames).abs().max(), (chain.jacobian(q) - jacobian).abs().max()
    )

    if not difference <= LARGEST_DIFFERENCE * frames.abs().max():  # NaN is none
        raise ArithmeticError(
            f"The closed form and pytorch-kinematics differ by {float(difference):.1e} for the "
            f"joints {choices(chain.names)}."
        )
