"""A round thing on a table: what a round hand that touches it does to it, and how it slides on."""

from dataclasses import dataclass

import torch
from torch import Tensor

from aicon_torch.differentiation import stop
from aicon_torch.parts.planar import norm, quarter_turn
from aicon_torch.parts.validation import check_not_negative, check_positive
from aicon_torch.shaping import by_gain, straight_through

GRAVITY = 9.81
"""m/s²."""

NO_MOTION = 1e-9
"""What counts as none, m and m/s."""


@dataclass(frozen=True)
class Sliding:
    """How a thing slides on, once nothing pushes it: slower by μ g, until it rests.

    Attributes:
        friction: μ between the thing and what it lies on.
    """

    friction: float

    def __post_init__(self) -> None:
        """Check the number."""
        check_positive(self, ("friction",))

    def displacement(self, v_obj: Tensor, dt: Tensor) -> Tensor:
        """(‖v‖ t − μ g t²/2) v/‖v‖ with t = min(dt, ‖v‖/(μ g)), ``(*B, 2)``, m.

        Args:
            v_obj: Its velocity, ``(*B, 2)``, m/s.
            dt: For how long, s.
        """
        slower = self.friction * GRAVITY
        speed = norm(v_obj).unsqueeze(-1)
        moving = torch.minimum(dt, speed / slower)
        return v_obj * moving * (1 - slower * moving / (2 * speed).clamp(min=NO_MOTION))

    def to_rest(self, v_obj: Tensor) -> Tensor:
        """‖v‖ v/(2 μ g): how far it slides until it rests, ``(*B, 2)``, m."""
        return v_obj * norm(v_obj).unsqueeze(-1) / (2 * self.friction * GRAVITY)


@dataclass(frozen=True)
class RoundObject:
    """A thing of radius R that a hand of radius r pushes.

    Attributes:
        radius: R, m.
        hand: r, m.
        friction: μ between hand and thing.
        reach: ℓ, how far off a contact is felt that is wanted, m.
        reaction: ℓ', how far off one is felt that is not, m.
    """

    radius: float
    hand: float
    friction: float
    reach: float
    reaction: float
    step: float = 1.0

    def gap(self, x_pusher: Tensor, x_place: Tensor) -> Tensor:
        """‖x − c‖ − R − r, ``(*B,)``, m."""
        return norm(x_place - x_pusher) - (self.radius + self.hand)

    def normal(self, x_pusher: Tensor, x_place: Tensor) -> Tensor:
        """N = (c − x)/‖c − x‖, along which the hand pushes, ``(*B, 2)``."""
        away = stop(x_place) - x_pusher
        return away / norm(away).unsqueeze(-1)

    def likelihood(self, x_pusher: Tensor, x_place: Tensor) -> Tensor:
        """Exp(−gap/ℓ) and exp(−gap/ℓ'): of a contact, wanted and not, ``(*B, 2)``."""
        gap = self.gap(x_pusher, stop(x_place))
        return torch.exp(torch.stack((-gap / self.reach, -gap / self.reaction), dim=-1))

    def push(self, x_place: Tensor, x_pusher: Tensor, d_pusher: Tensor) -> Tensor:
        """How far the hand pushes it on its way, ``(*B, 2)``, m.

        Args:
            x_place: Where its centre would be, ``(*B, 2)``, m.
            x_pusher: Where the hand arrives, ``(*B, 2)``, m.
            d_pusher: The hand's way, ``(*B, 2)``, m.
        """
        start = stop(x_pusher - d_pusher)
        normal = self.normal(start, x_place)
        gap = self.gap(start, stop(x_place)).clamp(min=0.0)

        along = (d_pusher * normal).sum(-1)
        side = quarter_turn(normal)
        slope = (d_pusher * side).sum(-1) / along.clamp(min=NO_MOTION)
        slope = slope.clamp(-self.friction, self.friction)

        beyond = (along - gap).clamp(min=0.0).unsqueeze(-1)
        return beyond * (normal + slope.unsqueeze(-1) * side)

    def moved(self, x_rest: Tensor, n_contact: Tensor, p_contact: Tensor) -> Tensor:
        """Where it is, moved by the contact to come, ``(*B, 2)``, m."""
        wanted, unwanted = p_contact.unsqueeze(-2).unbind(-1)
        by_likelihood = by_gain(stop(n_contact).unsqueeze(-2), wanted, unwanted)
        by_place = stop(wanted) * n_contact
        return straight_through(stop(x_rest), self.step * (by_likelihood + by_place)) + (
            x_rest - stop(x_rest)
        )
