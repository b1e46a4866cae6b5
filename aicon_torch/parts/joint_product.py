"""The product of a chain's joints, in closed form: each is affine in cos q, sin q and q."""

import math
from collections.abc import Sequence

import torch
from torch import Tensor, nn

from aicon_torch.errors import GraphError, OptionError
from aicon_torch.quantities import as_numbers

Transform = Sequence[Sequence[float]]
"""The first three rows of a homogeneous transform, with its position in m."""


class JointProduct(nn.Module):
    """The links of a chain at Tᵢ = Tᵢ₋₁ Fᵢ Mᵢ(qᵢ), T₀ = I, and a tool at Tₙ F_tool.

    Mᵢ turns about the unit vector a by Rodrigues' formula, R = aaᵀ + cos q (I − aaᵀ) + sin q [a]×,
    or slides along it, by q·a. Both are affine in (cos q, sin q, q), and so is Fᵢ Mᵢ: those of all
    joints are built at once, from constants.

    Args:
        fixed: Fᵢ for each of the n joints.
        tool: F_tool.
        axes: a for each joint, unit vectors.
        slides: Whether the joint slides.
    """

    constant: Tensor
    by_cos: Tensor
    by_sin: Tensor
    by_q: Tensor
    tool: Tensor

    def __init__(
        self,
        fixed: Sequence[Transform],
        tool: Transform,
        axes: Sequence[Sequence[float]],
        slides: Sequence[bool],
    ) -> None:
        super().__init__()
        transforms = torch.stack([homogeneous(transform) for transform in fixed])

        # Fᵢ Mᵢ = C + cos q C_cos + sin q C_sin + q C_q, where all four are constants.
        parts = [_motion(axis, slide) for axis, slide in zip(axes, slides, strict=True)]
        constant, by_cos, by_sin, by_q = torch.stack(parts, dim=1)

        self.slides = any(slides)
        self.register_buffer("constant", transforms @ constant)
        self.register_buffer("by_cos", transforms @ by_cos)
        self.register_buffer("by_sin", transforms @ by_sin)
        self.register_buffer("by_q", transforms @ by_q)
        self.register_buffer("tool", homogeneous(tool))

    def forward(self, x_joints: Tensor) -> Tensor:
        """The n links and the tool, ``(*B, n + 1, 4, 4)``, m, at q ``(*B, n)``, rad or m.

        Raises:
            GraphError: If q has not a number for each joint.
        """
        if x_joints.shape[-1:] != self.constant.shape[:1]:
            raise GraphError(
                f"Joint angles of shape {tuple(x_joints.shape)}: expected {len(self.constant)}, "
                "one for each joint of the chain."
            )

        # Each link in the frame of the one before it.
        q = x_joints[..., None, None]
        turning = torch.cos(q) * self.by_cos.to(q) + torch.sin(q) * self.by_sin.to(q)
        local = self.constant.to(q) + turning
        if self.slides:
            local = local + q * self.by_q.to(q)

        # Each link in the frame of the base.
        frame, *others = local.unbind(-3)
        frames = [frame]
        for step in others:
            frame = frame @ step
            frames.append(frame)

        frames.append(frame @ self.tool.to(q))
        return torch.stack(frames, dim=-3)


def homogeneous(rows: Transform) -> Tensor:
    """The transform ``(4, 4)`` whose first rows these are.

    Raises:
        OptionError: If they are not 3 or 4 rows of 4 finite numbers.
    """
    transform = torch.eye(4, dtype=torch.float64)
    given = as_numbers(rows[:3])
    if not isinstance(given, tuple) or len(given) != 12 or not all(map(math.isfinite, given)):
        raise OptionError(f"Transform {rows!r}: expected 3 rows of 4 finite numbers.")
    transform[:3] = torch.tensor(given, dtype=torch.float64).reshape(3, 4)
    return transform


def _motion(axis: Sequence[float], slides: bool) -> Tensor:
    """M(q): its constant and what multiplies cos q, sin q and q, ``(4, 4, 4)``."""
    direction = torch.as_tensor(axis, dtype=torch.float64)
    identity = torch.eye(3, dtype=torch.float64)
    parts = torch.zeros(4, 4, 4, dtype=torch.float64)

    # The last row of a transform is (0, 0, 0, 1), whatever q is.
    parts[0, 3, 3] = 1.0

    if slides:
        parts[0, :3, :3] = identity
        parts[3, :3, 3] = direction
        return parts

    # Rodrigues: aaᵀ, cos q (I − aaᵀ) and sin q [a]×.
    along = torch.outer(direction, direction)
    parts[0, :3, :3] = along
    parts[1, :3, :3] = identity - along
    parts[2, :3, :3] = torch.linalg.cross(identity, direction.expand(3, 3))  # [a]×
    return parts
