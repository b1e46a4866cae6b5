"""The end effector: its pose as lengths, and how a gradient goes from there to the joints."""

from dataclasses import dataclass
from functools import partial
from typing import Any, Literal, Protocol, get_args

import torch
from torch import Tensor, nn

from aicon_torch.differentiation import is_hop, is_literal, learns
from aicon_torch.errors import OptionError
from aicon_torch.parts.approach import ToolAxis
from aicon_torch.parts.chain import Chain
from aicon_torch.quantities import as_number
from aicon_torch.validation import check_choice, check_not_negative, check_positive

Pullback = Literal["natural", "transpose"]
"""Which joint gradient stands for a gradient of the end effector: see :class:`EndEffector`."""


class TipLengths(Protocol):
    """What x_ee is: the pose of a tip as k lengths."""

    def of_frame(self, tool: Tensor) -> Tensor:
        """x_ee ``(*B, k)``, m, of the tool's transform ``(*B, 4, 4)``."""
        ...

    def point(self, tool: Tensor) -> Tensor:
        """The point ``(*B, 3)``, m, whose position is a part of x_ee."""
        ...

    def jacobian(self, tool: Tensor, geometric: Tensor) -> Tensor:
        """∂x_ee/∂q ``(*B, k, n)``, from the geometric Jacobian of that point, ``(*B, 6, n)``."""
        ...


@dataclass(frozen=True)
class ToolPose:
    """x_ee: the pose of a long tool that points down, as six lengths ``(*B, 6)``, m.

    They are the position (x, y, z) of the tip, the tilt L·(x, y) of the tool's z axis, and the
    heading L·ψ of its x axis, ψ being the angle of that axis in the plane. All six have one unit,
    so gradients of positions and of angles can be compared.

    Attributes:
        length: Distance of the tip from the origin of the tool along its z axis, m.
        lever: L: a rotation by one rad counts as much as a motion by this, m.

    Raises:
        OptionError: If the length is negative, or the lever not positive.
    """

    length: float
    lever: float

    def __post_init__(self) -> None:
        """Check the lengths."""
        check_not_negative(self, ("length",))
        check_positive(self, ("lever",))

    def of_frame(self, tool: Tensor) -> Tensor:
        """x_ee ``(*B, 6)`` of the tool's transform ``(*B, 4, 4)``."""
        x_axis, _, z_axis, _ = tool[..., :3, :].unbind(-1)
        x, y, _ = torch.split(x_axis, 1, dim=-1)
        heading = torch.atan2(y, x)

        directions = (self.lever * z_axis[..., :2], self.lever * heading)
        return torch.cat((self.point(tool), *directions), dim=-1)

    def point(self, tool: Tensor) -> Tensor:
        """The tip, ``(*B, 3)``, m."""
        _, _, z_axis, origin = tool[..., :3, :].unbind(-1)
        return origin + self.length * z_axis

    def jacobian(self, tool: Tensor, geometric: Tensor) -> Tensor:
        """∂x_ee/∂q ``(*B, 6, n)``, from the geometric Jacobian of the tip, ``(*B, 6, n)``."""
        x_axis, _, z_axis, _ = tool[..., :3, :].unbind(-1)
        tip_motion, turning = torch.split(geometric.mT, 3, dim=-1)

        # A turn about an axis moves a direction by axis × direction.
        x_axis, z_axis = x_axis.unsqueeze(-2), z_axis.unsqueeze(-2)
        x_motion = torch.linalg.cross(turning, x_axis.expand_as(turning))
        z_motion = torch.linalg.cross(turning, z_axis.expand_as(turning))

        # ψ = atan2(y, x), so dψ = (x dy − y dx)/(x² + y²).
        x, y, _ = torch.split(x_axis, 1, dim=-1)
        dx, dy, _ = torch.split(x_motion, 1, dim=-1)
        heading_motion = (x * dy - y * dx) / (x * x + y * y)

        rows = (tip_motion, self.lever * z_motion[..., :2], self.lever * heading_motion)
        return torch.cat(rows, dim=-1).mT

    def to_frame(self, x_ee: Tensor) -> tuple[Tensor, Tensor]:
        """The inverse: rotation ``(*B, 3, 3)`` and origin ``(*B, 3)`` of the tool, m."""
        tilt, heading = x_ee[..., 3:5] / self.lever, x_ee[..., 5] / self.lever

        # The tool points down, so of both roots it is the negative one, and never level.
        down = -torch.sqrt((1 - (tilt * tilt).sum(-1, keepdim=True)).clamp(min=0.05))
        z_axis = torch.cat((tilt, down), dim=-1)

        # The x axis has this heading and is perpendicular to the z axis, which decides its rise.
        level = torch.stack((torch.cos(heading), torch.sin(heading)), dim=-1)
        rise = -(tilt * level).sum(-1, keepdim=True) / down
        x_axis = torch.cat((level, rise), dim=-1)
        x_axis = x_axis / torch.linalg.vector_norm(x_axis, dim=-1, keepdim=True)

        y_axis = torch.linalg.cross(z_axis, x_axis)
        rotation = torch.stack((x_axis, y_axis, z_axis), dim=-1)
        return rotation, x_ee[..., :3] - self.length * z_axis


class EndEffector(nn.Module):
    """x_ee of a chain, and which joint gradient stands for a gradient of x_ee.

    A gradient h says where x_ee is to go. ``"natural"`` asks for the joints that take it there,
    along J⁺h, the steepest descent in the metric of the table: see :meth:`natural_gradient`.
    ``"transpose"`` is the chain rule itself, Jᵀh, the steepest descent in the metric of the
    joints, whose motion of the tip points up to 40° away from h.

    Args:
        chain: From the joints to the tool.
        pose: From the tool to x_ee, such as :class:`aicon_torch.parts.tip_pose.TipPose`.
        pullback: Which of them.
        damping: λ of the damped pseudo-inverse, m/rad.
        turns_within: r: at a distance d from its target a turn of the tip counts w = 1/(1 + (d/r)²)
            times as much, so that it waits until the place is near: J and h are those of the
            lengths (p, w·turns). None where turns count alike everywhere; else it also reads the
            target, ``Interconnection(end_effector, ["x_joints", "x_target"])``.
        advance: How much an advance along the axis of the tool counts once the direct way has been
            found closed; None where it always counts alike. Else it also reads x_approach, of
            :class:`aicon_torch.parts.Approach`.

    Raises:
        OptionError: If there is no such pullback, the distance is not positive, or the
            damping is negative.

    Example:
        >>> end_effector = EndEffector(chain, ToolPose(length=0.3, lever=0.2))
        >>> tip = end_effector(q)[..., :3]
    """

    def __init__(
        self,
        chain: Chain,
        pose: TipLengths,
        pullback: Pullback = "natural",
        damping: float = 0.02,
        turns_within: float | None = None,
        advance: ToolAxis | None = None,
    ) -> None:
        super().__init__()
        self.chain, self.pose = chain, pose
        self.pullback, self.damping, self.turns_within = pullback, damping, turns_within
        self.advance = advance
        check_choice(self, "pullback", get_args(Pullback))
        check_not_negative(self, ("damping",))
        if turns_within is not None and not as_number(turns_within) > 0:
            raise OptionError(f"turns_within={turns_within!r}: expected a distance > 0 (m).")

    def forward(
        self, x_joints: Tensor, x_target: Tensor | None = None, x_approach: Tensor | None = None
    ) -> Tensor:
        """x_ee ``(*B, k)``, m, at the joint angles ``(*B, n)``, rad, on its way to a target."""
        by_chain_rule = self.pullback == "transpose" or is_literal()
        if by_chain_rule or not x_joints.requires_grad:
            return self.at(self.chain.frames(x_joints))

        # While something learns, its loss goes by the chain rule, and a hop as it always does.
        pull_back: Any = _NaturalPullback.apply
        if learns():
            at_joints = self.at(self.chain.frames(x_joints))
            pull_back = partial(_NaturalHop.apply, at_joints)
        x_ee: Tensor = pull_back(x_joints, x_target, x_approach, self)
        return x_ee

    def weights(self, x_ee: Tensor, x_target: Tensor | None) -> Tensor | None:
        """How much each length counts on the way to a target, ``(*B, k)``; None for all alike."""
        if self.turns_within is None or x_target is None:
            return None
        offset = (x_ee - x_target)[..., :3] / self.turns_within
        of_turns = 1.0 / (1.0 + (offset * offset).sum(-1, keepdim=True))
        turns = x_ee[..., 3:]
        return torch.cat((torch.ones_like(offset), of_turns.expand_as(turns)), dim=-1)

    def jacobian(self, x_joints: Tensor) -> Tensor:
        """J = ∂x_ee/∂q, ``(*B, k, n)``, m/rad, at the joint angles ``(*B, n)``."""
        return self.jacobian_at(self.chain.frames(x_joints))

    def at(self, frames: Tensor) -> Tensor:
        """x_ee ``(*B, k)`` where the chain has these frames ``(*B, n + 1, 4, 4)``."""
        return self.pose.of_frame(frames[..., -1, :, :])

    def jacobian_at(self, frames: Tensor) -> Tensor:
        """J ``(*B, k, n)`` there, from the geometric Jacobian of the tip."""
        tool = frames[..., -1, :, :]
        geometric = self.chain.jacobian_at(frames, self.pose.point(tool))
        return self.pose.jacobian(tool, geometric)

    def solve(self, jacobian: Tensor, motion: Tensor) -> Tensor:
        """J⁺w = Jᵀ(JJᵀ + λ²I)⁻¹ w = (JᵀJ + λ²I)⁻¹Jᵀ w, the joints' motion that moves x_ee by w.

        Args:
            jacobian: J, ``(*B, k, n)``.
            motion: w, ``(*B, k)``.

        Returns:
            ``(*B, n)``.
        """
        lengths, joints = jacobian.shape[-2:]
        column = motion.unsqueeze(-1)

        # Of the two forms the one with the smaller matrix.
        if lengths <= joints:
            solution = jacobian.mT @ self._solve_damped(jacobian @ jacobian.mT, column)
        else:
            solution = self._solve_damped(jacobian.mT @ jacobian, jacobian.mT @ column)
        return solution.squeeze(-1)

    def _solve_damped(self, square: Tensor, column: Tensor) -> Tensor:
        """(S + λ²I)⁻¹ c, ``(*B, m, 1)``, for a symmetric S ``(*B, m, m)``."""
        identity = torch.eye(square.shape[-1], dtype=square.dtype, device=square.device)
        damped = square + self.damping**2 * identity
        solution: Tensor = torch.linalg.solve_ex(damped, column).result
        return solution

    def natural_gradient(self, jacobian: Tensor, gradient: Tensor) -> Tensor:
        """The joint gradient along J⁺h for a gradient h of x_ee.

        Its length is that of a gradient in this direction, the change of the cost per rad,
        hᵀJJ⁺h / ‖J⁺h‖. The length of J⁺h itself would say how far the joints must go, and near a
        singularity outgrow all gradients that it meets.

        Args:
            jacobian: J, ``(*B, k, n)``.
            gradient: h, ``(*B, k)``.

        Returns:
            ``(*B, n)``.
        """
        # J⁺h, and how x_ee moves by it.
        joint_motion = self.solve(jacobian, gradient)
        motion = (jacobian @ joint_motion.unsqueeze(-1)).squeeze(-1)

        # In its direction, at the length by which the cost changes per rad: J⁺h · hᵀJJ⁺h/‖J⁺h‖².
        change = (gradient * motion).sum(-1, keepdim=True)
        square = (joint_motion * joint_motion).sum(-1, keepdim=True)
        return joint_motion * (change / square.clamp(min=torch.finfo(square.dtype).tiny))


class _NaturalPullback(torch.autograd.Function):
    """x_ee forward, the natural gradient backward."""

    @staticmethod
    def forward(
        ctx: Any,
        x_joints: Tensor,
        x_target: Tensor | None,
        x_approach: Tensor | None,
        end_effector: EndEffector,
    ) -> Tensor:
        frames = end_effector.chain.frames(x_joints)
        ctx.end_effector, ctx.way = end_effector, (x_target, x_approach)
        ctx.save_for_backward(frames)
        return end_effector.at(frames)

    @staticmethod
    def backward(ctx: Any, *gradients: Any) -> tuple[Tensor, None, None, None]:
        (frames,) = ctx.saved_tensors
        joint_gradient = _joint_gradient(ctx.end_effector, frames, ctx.way, gradients[0])
        return joint_gradient, None, None, None


class _NaturalHop(torch.autograd.Function):
    """x_ee forward; backward the natural gradient in a hop, which is itself differentiable."""

    @staticmethod
    def forward(
        ctx: Any,
        x_ee: Tensor,
        x_joints: Tensor,
        x_target: Tensor | None,
        x_approach: Tensor | None,
        end_effector: EndEffector,
    ) -> Tensor:
        ctx.end_effector, ctx.way = end_effector, (x_target, x_approach)
        ctx.save_for_backward(x_joints)
        return x_ee.view_as(x_ee)

    @staticmethod
    def backward(
        ctx: Any, *gradients: Any
    ) -> tuple[Tensor | None, Tensor | None, None, None, None]:
        # The gradient of a loss goes by the chain rule, through x_ee itself.
        if not is_hop():
            return gradients[0], None, None, None, None
        (x_joints,) = ctx.saved_tensors

        # Computed here, so that the natural gradient is a function of the joints that can be
        # differentiated in its turn.
        frames = ctx.end_effector.chain.frames(x_joints)
        joint_gradient = _joint_gradient(ctx.end_effector, frames, ctx.way, gradients[0])
        return None, joint_gradient, None, None, None


def _joint_gradient(
    end_effector: EndEffector,
    frames: Tensor,
    way: tuple[Tensor | None, Tensor | None],
    gradient: Tensor,
) -> Tensor:
    """The natural gradient ``(*B, n)`` of a gradient of x_ee, as its lengths count there.

    Args:
        end_effector: The end effector.
        frames: Where the chain has its frames, ``(*B, n + 1, 4, 4)``.
        way: The target and x_approach; None where they are not read.
        gradient: h, ``(*B, k)``.
    """
    jacobian, x_ee = end_effector.jacobian_at(frames), end_effector.at(frames)
    x_target, x_approach = way

    # Where the direct way is closed, an advance waits.
    if end_effector.advance is not None and x_target is not None and x_approach is not None:
        gated = end_effector.advance.gated(gradient, x_ee, x_target)
        gradient = torch.where(x_approach[..., :1] > 0.5, gated, gradient)

    # J and h of the lengths as they count on the way to the target.
    weights = end_effector.weights(x_ee, x_target)
    if weights is not None:
        jacobian, gradient = weights.unsqueeze(-1) * jacobian, weights * gradient
    return end_effector.natural_gradient(jacobian, gradient)
