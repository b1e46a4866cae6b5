"""Forward kinematics of a serial chain of revolute joints, from plain numbers.

Not that of pytorch-kinematics: its URDF loader rounds to float32 (2.4e-8 m), and a chain that is
built from numbers is as long as the product here, makes a step a tenth slower and needs four more
packages. docs/research/panda_push.md has the figures.
"""

from collections.abc import Sequence

import torch
from torch import Tensor, nn

Transform = Sequence[Sequence[float]]
"""The first three rows of a homogeneous transform, with its position in m."""


class Chain(nn.Module):
    """A serial chain: after a fixed transform Fᵢ, link i turns about its own z axis by qᵢ.

    Link i is at Tᵢ = Tᵢ₋₁ Fᵢ R_z(qᵢ) in the frame of the base (T₀ = I), and the tool, which is
    fixed to the last link, at Tₙ F_tool. Each Fᵢ R_z(qᵢ) is affine in (cos qᵢ, sin qᵢ), so those of
    all joints are built at once.

    Args:
        fixed: Fᵢ for each of the n joints.
        tool: F_tool.

    Example:
        >>> chain = Chain(PANDA.frames, PANDA.tool)
        >>> tool = chain.frames(q)[..., -1, :, :]
    """

    constant: Tensor
    by_cos: Tensor
    by_sin: Tensor
    tool: Tensor

    def __init__(self, fixed: Sequence[Transform], tool: Transform) -> None:
        super().__init__()
        transforms = torch.stack([_homogeneous(transform) for transform in fixed])
        x, y, z, position = torch.split(transforms, 1, dim=-1)
        zero = torch.zeros_like(x)

        # F R_z(q) = [z and position] + cos q [x, y] + sin q [y, −x], column by column.
        self.register_buffer("constant", torch.cat((zero, zero, z, position), dim=-1))
        self.register_buffer("by_cos", torch.cat((x, y, zero, zero), dim=-1))
        self.register_buffer("by_sin", torch.cat((y, -x, zero, zero), dim=-1))
        self.register_buffer("tool", _homogeneous(tool))

    def frames(self, x_joints: Tensor) -> Tensor:
        """Transforms of the n links and, last, of the tool.

        Args:
            x_joints: q, ``(*B, n)``, rad.

        Returns:
            ``(*B, n + 1, 4, 4)`` in the frame of the base, m.
        """
        # Each link in the frame of the one before it.
        q = x_joints[..., None, None]
        turning = torch.cos(q) * self.by_cos.to(q) + torch.sin(q) * self.by_sin.to(q)
        local = self.constant.to(q) + turning

        # Each link in the frame of the base.
        frame, *others = local.unbind(-3)
        frames = [frame]
        for step in others:
            frame = frame @ step
            frames.append(frame)

        frames.append(frame @ self.tool.to(q))
        return torch.stack(frames, dim=-3)


def _homogeneous(rows: Transform) -> Tensor:
    """The transform ``(4, 4)`` whose first rows these are."""
    transform = torch.eye(4, dtype=torch.float64)
    transform[:3] = torch.tensor(rows[:3], dtype=torch.float64)
    return transform
