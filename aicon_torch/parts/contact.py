"""The geometry-based contact model: where the pusher may touch a side of the object, and how likely that is.

Everything here is written for one side; the graph evaluates it for each.
"""

from dataclasses import dataclass

import torch
from torch import Tensor

from aicon_torch.parts.servo import RADIUS


def norm(vectors: Tensor) -> Tensor:
    """Euclidean norm ``(*B,)`` of vectors ``(*B, d)``, with a derivative at zero."""
    return torch.sqrt((vectors * vectors).sum(-1) + 1e-18)


def tangent(x_side: Tensor) -> Tensor:
    """Unit vector along a side (start, end) ``(*B, 4)``, ``(*B, 2)``."""
    along = x_side[..., 2:] - x_side[..., :2]
    return along / norm(along).unsqueeze(-1)


def inward(x_side: Tensor) -> Tensor:
    """Unit normal of a side into the object, ``(*B, 2)``."""
    x, y = tangent(x_side).unbind(-1)
    return torch.stack((-y, x), dim=-1)


def closest_point(x_pusher: Tensor, x_side: Tensor) -> Tensor:
    """x_contact: the point of a side that is closest to the pusher, ``(*B, 2)``, px."""
    start, along = x_side[..., :2], x_side[..., 2:] - x_side[..., :2]
    share = ((x_pusher - start) * along).sum(-1, keepdim=True) / (along * along).sum(-1, keepdim=True).clamp(min=1e-9)
    return start + share.clamp(0.0, 1.0) * along


def held_point(x_pusher: Tensor, x_side: Tensor) -> Tensor:
    """x_contact as a constant, which leaves p₂ out."""
    return closest_point(x_pusher, x_side).detach()


@dataclass(frozen=True)
class ContactLikelihood:
    """p_contact as a contact that is sought and as one that just happens, ``(*B, 2)``.

    The first reaches as far as one travels to a contact, p = exp(−d/ℓ) with the distance d to a point just outside the
    side; the second as far as one reacts to what is in the way, p = exp(−gap/ℓ'). Which of them counts is decided by
    the edge that uses them (:func:`aicon_torch.by_gain`). The text has one likelihood for both.

    Attributes:
        reach: ℓ, px.
        reaction: ℓ', px.
        aim: How far outside the side a sought contact is aimed at, px.
        facing: Whether a contact that just happens at a corner counts as far as the side faces the pusher.
        radius: Radius of the pusher, px.
    """

    reach: float
    reaction: float
    aim: float
    facing: bool
    radius: float = RADIUS

    def __call__(self, x_pusher: Tensor, x_contact: Tensor, x_side: Tensor) -> Tensor:
        """The two likelihoods of a contact with one side."""
        point = x_contact.detach()  # the closest point: what its motion adds to a distance is zero
        normal = inward(x_side)
        to_point = point - x_pusher
        sought = torch.exp(-(norm(to_point - self.aim * normal) - (self.radius - self.aim)) / self.reach)
        distance = norm(to_point)
        happens = torch.exp(-(distance - self.radius) / self.reaction)
        if self.facing:
            faces = ((normal * to_point).sum(-1) / distance).clamp(min=0.0).detach()  # a share of the likelihood
            happens = torch.where(interior(point, x_side), happens, faces * happens)
        return torch.stack((sought, happens), dim=-1)


def interior(point: Tensor, x_side: Tensor) -> Tensor:
    """Whether a point of a side is not one of its ends, ``(*B,)``."""
    start, end = x_side[..., :2], x_side[..., 2:]
    return ((point - start).abs().amax(-1) > 1e-6) & ((point - end).abs().amax(-1) > 1e-6)
