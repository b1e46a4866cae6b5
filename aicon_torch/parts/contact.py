"""The contact model's geometry: where a pusher may touch an object, and how likely that is.

Everything here is written for one side, (start, end) in m; a graph evaluates it for each. The
inside of the object is on the left of a side as it is walked from its start to its end, with x to
the right and y up.
"""

from dataclasses import dataclass

import torch
from torch import Tensor

from aicon_torch.differentiation import stop
from aicon_torch.parts.planar import norm, quarter_turn
from aicon_torch.vectors import select

END_TOLERANCE = 1e-6
"""Distance from the end of a side within which a point counts as that end, m: what single precision
rounds at a distance of some metres."""


def tangent(x_side: Tensor) -> Tensor:
    """Unit vector t = (end − start)/‖end − start‖ along a side ``(*B, 4)``, ``(*B, 2)``."""
    along = x_side[..., 2:] - x_side[..., :2]
    return along / norm(along).unsqueeze(-1)


def inward_normal(x_side: Tensor) -> Tensor:
    """Unit normal n = (−t_y, t_x) of a side ``(*B, 4)`` into the object, ``(*B, 2)``."""
    return quarter_turn(tangent(x_side))


def closest_point(x_pusher: Tensor, x_side: Tensor) -> Tensor:
    """x_contact: the point of a side that is closest to the pusher.

    Args:
        x_pusher: Centre of the pusher, ``(*B, 2)``, m.
        x_side: The side, ``(*B, 4)``, m.

    Returns:
        ``(*B, 2)``, m.
    """
    start, along = x_side[..., :2], x_side[..., 2:] - x_side[..., :2]

    # Where the perpendicular from the pusher meets the side, as a share of it; at most its ends.
    squared_length = (along * along).sum(-1, keepdim=True).clamp(min=1e-15)

    share = ((x_pusher - start) * along).sum(-1, keepdim=True) / squared_length
    return start + share.clamp(0.0, 1.0) * along


def fixed_closest_point(x_pusher: Tensor, x_side: Tensor) -> Tensor:
    """x_contact as a constant, ``(*B, 2)``, m, which leaves out p₂, the path over its position."""
    contact = closest_point(x_pusher, x_side)
    return stop(contact)  # stops the gradient by the position of the contact


def nearest_point(x_pusher: Tensor, sides: Tensor) -> tuple[Tensor, Tensor]:
    """The point of an object with K sides ``(*B, K, 4)`` that is closest to the pusher ``(*B, 2)``.

    Returns:
        The point ``(*B, 2)``, m, and its distance ``(*B, 1)``, m.
    """
    pusher = x_pusher.unsqueeze(-2)
    points = closest_point(pusher, sides)
    distances = norm(points - pusher)
    nearest = distances.argmin(-1, keepdim=True)
    return select(points, nearest), distances.gather(-1, nearest)


def is_interior(point: Tensor, x_side: Tensor) -> Tensor:
    """Whether a point ``(*B, 2)`` of a side ``(*B, 4)`` is neither of its ends, ``(*B,)``."""
    start, end = x_side[..., :2], x_side[..., 2:]
    after_start = (point - start).abs().amax(-1) > END_TOLERANCE
    before_end = (point - end).abs().amax(-1) > END_TOLERANCE
    return after_start & before_end


def likelihood_across(gap: Tensor, reach: float) -> Tensor:
    """How likely it is that a gap d ``(*B,)``, m, is closed: p = exp(−d/ℓ), ``(*B,)``.

    Args:
        gap: d; more than certain where it is negative.
        reach: ℓ, m.
    """
    return torch.exp(-gap / reach)


@dataclass(frozen=True)
class ContactLikelihood:
    """p_contact: how likely a contact is, as one that is intended and as one that just happens.

    One formula for both: from the pusher x to a point outside the closest point c of the side, by a
    along its inward normal n,

        p = exp(−(‖c − a n − x‖ − (r − a))/ℓ).

    An intended contact reaches as far as one travels to it, ℓ, and is aimed at outside the side.
    One that just happens reaches as far as one reacts to what is in the way, ℓ', with a = 0, and
    counts at an end of the side as far as that faces the pusher. Which of them counts is decided by
    the edge that uses them (:func:`aicon_torch.by_gain`). The text has one likelihood for both.

    Attributes:
        reach: ℓ, m.
        reaction: ℓ', m.
        aim: a, how far outside the side an intended contact is aimed at, m.
        facing: Whether a contact that just happens at a corner counts as far as the side faces the
            pusher.
        radius: r of the pusher, m.
        inset: How far from the ends of its side an intended contact is aimed at, m, or in the
            middle of a shorter side: at an end the pusher slips around the corner.
    """

    reach: float
    reaction: float
    aim: float
    facing: bool
    radius: float
    inset: float = 0.0

    def __call__(self, x_pusher: Tensor, x_contact: Tensor, x_side: Tensor) -> Tensor:
        """The two likelihoods of a contact with one side.

        Args:
            x_pusher: Centre of the pusher, ``(*B, 2)``, m.
            x_contact: The closest point of the side, ``(*B, 2)``, m.
            x_side: The side, ``(*B, 4)``, m.

        Returns:
            Intended and incidental, ``(*B, 2)``.
        """
        point = stop(x_contact)  # nothing: by the motion of the closest point no distance changes
        normal = inward_normal(x_side)
        to_point = point - x_pusher

        # At a corner a contact just happens as far as the side faces the pusher.
        share = self._facing(to_point, normal, is_interior(point, x_side)) if self.facing else 1.0

        # One that is intended is aimed outside the side, away from its ends; one that just happens
        # is where it is.
        to_aim = to_point + self._inset(point, x_side) - self.aim * normal
        intended = self._at_distance(norm(to_aim), self.aim, self.reach)
        incidental = share * self._at_distance(norm(to_point), 0.0, self.reaction)
        return torch.stack((intended, incidental), dim=-1)

    def _at_distance(self, distance: Tensor, aim: float, reach: float) -> Tensor:
        """Likelihood exp(−(‖c − a n − x‖ − (r − a))/ℓ), ``(*B,)``, from the norm ``(*B,)``, m."""
        return likelihood_across(distance - (self.radius - aim), reach)

    def _inset(self, point: Tensor, x_side: Tensor) -> Tensor:
        """From a point of a side to the nearest that is not too near an end, ``(*B, 2)``, m."""
        if self.inset == 0:
            return torch.zeros_like(point)

        start, along = x_side[..., :2], tangent(x_side)

        # No nearer to an end than the inset, or in the middle where the side is too short for that.
        length = norm(x_side[..., 2:] - start)
        place = ((point - start) * along).sum(-1)
        least = (length / 2).clamp(max=self.inset)

        inside = torch.minimum(torch.maximum(place, least), length - least)
        shift = (inside - place).unsqueeze(-1) * along
        return stop(shift)  # stops the gradient: where to aim is no goal

    def _facing(self, to_point: Tensor, normal: Tensor, interior: Tensor) -> Tensor:
        """How far the side faces the pusher: 1, and at its ends max(0, cos), ``(*B,)``."""
        cosine = (normal * to_point).sum(-1) / norm(to_point)
        share = stop(cosine.clamp(min=0.0))  # stops the gradient: it weighs, and is no goal
        return torch.where(interior, 1.0, share)
