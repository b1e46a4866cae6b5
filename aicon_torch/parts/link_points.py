"""Points that are fixed to the links of a chain: all of them, or a few that a step chooses."""

from collections.abc import Sequence
from typing import Any

import torch
from torch import Tensor, nn

from aicon_torch.differentiation import learns
from aicon_torch.parts.chain import Chain
from aicon_torch.vectors import select

Point = tuple[float, float, float]


class LinkPoints(nn.Module):
    """Where points of links are in the frame of the base.

    Args:
        chain: The joints, n of them.
        links: The link of each point: 0 for the base, i for the one after joint i, n + 1 for the
            tool.
        points: Where each is in the frame of its link, m.
    """

    points: Tensor
    links: Tensor

    def __init__(self, chain: Chain, links: Sequence[int], points: Sequence[Point]) -> None:
        super().__init__()
        self.chain = chain
        self.register_buffer("points", torch.tensor(points, dtype=torch.float64))
        self.register_buffer("links", torch.tensor(links), persistent=False)

    def forward(self, x_joints: Tensor) -> Tensor:
        """All N points ``(*B, N, 3)``, m, at the joint angles ``(*B, n)``, rad or m."""
        frames = _with_base(self.chain.frames(x_joints))
        return _moved(frames[..., self.links, :, :], self.points.to(frames))

    def chosen(self, x_joints: Tensor, which: Tensor) -> Tensor:
        """Some of the points, by their numbers.

        The slope of a chosen point is its column of the geometric Jacobian, in place of a product
        of transforms, of which each would be differentiated. The numbers are known when a step
        runs only.

        Args:
            x_joints: m copies of one and the same posture, ``(m, *B, n)``, rad or m.
            which: The numbers of k points for each copy, ``(k, ..., m, *B)``.

        Returns:
            ``(k, ..., m, *B, 3)``, m.
        """
        own, link = self.points.to(x_joints)[which], self.links[which]
        if learns() or not x_joints.requires_grad:
            frames = _with_base(self.chain.frames(x_joints))
            return _moved(_frame_of(frames.expand(*link.shape, *frames.shape[-3:]), link), own)

        # A link is moved by the joints before it.
        joints = torch.arange(x_joints.shape[-1], device=x_joints.device)
        moves = (joints < self.links.unsqueeze(-1)).to(x_joints)[which]
        arguments = (x_joints, self.chain, link, own, moves)
        # torch gives `apply` no types.
        point: Tensor = _Chosen.apply(*arguments)  # type: ignore[no-untyped-call]
        return point


class _Chosen(torch.autograd.Function):
    """A point of a link forward, its Jacobian backward."""

    @staticmethod
    def forward(
        ctx: Any, x_joints: Tensor, chain: Chain, link: Tensor, own: Tensor, moves: Tensor
    ) -> Tensor:
        frames = chain.frames(x_joints[:1])  # all are copies of the first
        frames = frames[(None,) * (link.dim() + 3 - frames.dim())]
        with_base = _with_base(frames)
        of_copies = with_base.expand(*link.shape, *with_base.shape[-3:])
        point = _moved(_frame_of(of_copies, link), own)
        ctx.joints = x_joints.shape
        ctx.chain = chain
        ctx.save_for_backward(frames, point, moves)
        return point

    @staticmethod
    def backward(ctx: Any, *gradients: Any) -> tuple[Tensor, None, None, None, None]:
        frames, point, moves = ctx.saved_tensors
        motion = ctx.chain.point_jacobian_at(frames, point)
        slopes = (motion * gradients[0].unsqueeze(-1)).sum(-2)
        slopes = slopes * moves

        # What was chosen several times for a copy adds up.
        several = tuple(range(slopes.dim() - len(ctx.joints)))
        return (slopes.sum(several) if several else slopes), None, None, None, None


def _with_base(frames: Tensor) -> Tensor:
    """The frames of the links ``(*B, K, 4, 4)`` after that of the base, the identity."""
    base = torch.eye(4, dtype=frames.dtype, device=frames.device)
    return torch.cat((base.expand_as(frames[..., :1, :, :]), frames), dim=-3)


def _moved(frames: Tensor, points: Tensor) -> Tensor:
    """Points ``(*B, 3)`` of links with the frames ``(*B, 4, 4)``, in the frame of the base."""
    turned = (frames[..., :3, :3] * points.unsqueeze(-2)).sum(-1)
    return turned + frames[..., :3, 3]


def _frame_of(frames: Tensor, number: Tensor) -> Tensor:
    """One of K frames ``(*B, K, 4, 4)`` by its number ``(*B,)``."""
    chosen = select(frames.flatten(-2), number.unsqueeze(-1))
    return chosen.reshape(*chosen.shape[:-1], 4, 4)
