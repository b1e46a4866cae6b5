"""A round thing on a table: how a round pusher moves it, and how it slides on until it rests."""

from dataclasses import dataclass

import torch
from torch import Tensor

from aicon_torch.differentiation import stop
from aicon_torch.estimation import Deterministic
from aicon_torch.parts.contact import likelihood_across
from aicon_torch.parts.contact_options import ContactOptions
from aicon_torch.parts.planar import norm, quarter_turn
from aicon_torch.parts.touch import GRAVITY
from aicon_torch.shaping import by_gain, straight_through
from aicon_torch.validation import check_positive

NONE = 1e-9
"""A motion that counts as none, m or m/s."""


@dataclass(frozen=True)
class RoundObject:
    """A thing of radius R on a table, which a pusher of radius r touches at one point.

    It has momentum: pushed with the velocity v it slides on for v²/(2 μ g), and where it comes to
    rest depends on the pusher's motion by a gradient of its own. Its turning is left out, and so
    are corners; a thing that is about as long as wide counts as round.

    Attributes:
        radius: R, m.
        pusher_radius: r, m.
        friction: μ, between the thing and the table, and between the thing and the pusher.
        contact: How far off contacts are felt.

    Raises:
        OptionError: If a number is not positive.

    Example:
        >>> puck = RoundObject(0.02, pusher_radius=0.01, friction=1.0, contact=ContactOptions(0.4))
        >>> pusher = [Deterministic("d_pusher", way), Deterministic("x_pusher", place)]
        >>> estimators = [*pusher, *puck.estimators()]
    """

    radius: float
    pusher_radius: float
    friction: float
    contact: ContactOptions

    def __post_init__(self) -> None:
        """Check the numbers."""
        check_positive(self, ("radius", "pusher_radius", "friction"))

    def estimators(self) -> list[Deterministic]:
        """From its readings z_place and v_obj, and d_pusher and x_pusher, to x_obj."""
        return [
            Deterministic("x_slid", self.slid),
            Deterministic("d_push", self.push),
            Deterministic("x_rest", self.rest),
            Deterministic("n_contact", self.normal),
            Deterministic("p_contact", self.likelihood),
            Deterministic("x_obj", self.moved),
        ]

    def slid(self, z_place: Tensor, v_obj: Tensor, dt: Tensor) -> Tensor:
        """Where it is after a step in which nothing pushes it, ``(*B, 2)``, m.

        c + (t − μ g t²/(2 ‖v‖)) v with t = min(dt, ‖v‖/(μ g)).

        Args:
            z_place: c, where its centre is, ``(*B, 2)``, m.
            v_obj: v, its velocity, ``(*B, 2)``, m/s.
            dt: Time step, s.
        """
        speed = norm(v_obj).unsqueeze(-1)
        moving = torch.minimum(dt, speed / self._slower)
        return z_place + v_obj * moving * (1 - self._slower * moving / (2 * speed).clamp(min=NONE))

    def push(self, x_slid: Tensor, x_pusher: Tensor, d_pusher: Tensor) -> Tensor:
        """How far a pusher pushes it beyond where it slides, ``(*B, 2)``, m.

        The pusher's way d goes beyond the gap by s = max(d·n − max(gap, 0), 0), and the thing goes
        along as far as friction holds it: s (n + clip(d·t/d·n, ±μ) t). Its gradient goes by d.

        Args:
            x_slid: Where it would be, ``(*B, 2)``, m.
            x_pusher: Where the pusher arrives, ``(*B, 2)``, m.
            d_pusher: d, its way through the step, ``(*B, 2)``, m.
        """
        start, place = stop(x_pusher - d_pusher), stop(x_slid)
        normal = self.normal(start, place)
        along = (d_pusher * normal).sum(-1, keepdim=True)
        beyond = (along - self._gap(start, place).unsqueeze(-1).clamp(min=0.0)).clamp(min=0.0)

        side = quarter_turn(normal)
        slope = (d_pusher * side).sum(-1, keepdim=True) / along.clamp(min=NONE)
        return beyond * (normal + slope.clamp(-self.friction, self.friction) * side)

    def rest(
        self, z_place: Tensor, x_slid: Tensor, d_push: Tensor, v_obj: Tensor, dt: Tensor
    ) -> Tensor:
        """Where it comes to rest, c' + ‖v'‖ v'/(2 μ g), ``(*B, 2)``, m.

        c' is where the step brings it. Its velocity v' there is that of the step where it was
        pushed, and otherwise the one before less μ g dt.

        Args:
            z_place: Where it was, ``(*B, 2)``, m.
            x_slid: Where it would be unpushed, ``(*B, 2)``, m.
            d_push: How far it is pushed beyond, ``(*B, 2)``, m.
            v_obj: Its velocity before, ``(*B, 2)``, m/s.
            dt: Time step, s.
        """
        speed = norm(v_obj).unsqueeze(-1)
        slowed = v_obj * (1 - self._slower * dt / speed.clamp(min=NONE)).clamp(min=0.0)

        place = x_slid + d_push
        is_pushed = norm(d_push).unsqueeze(-1) > NONE
        velocity = torch.where(is_pushed, (place - z_place) / dt, slowed)
        return place + velocity * norm(velocity).unsqueeze(-1) / (2 * self._slower)

    def normal(self, x_pusher: Tensor, x_rest: Tensor) -> Tensor:
        """Along which the pusher at x would push it: n = (c − x)/‖c − x‖, ``(*B, 2)``."""
        to_centre = stop(x_rest) - x_pusher  # stops the gradient: where it is is the push's matter
        return to_centre / norm(to_centre).unsqueeze(-1)

    def likelihood(self, x_pusher: Tensor, x_rest: Tensor) -> Tensor:
        """Of a contact that is intended and of one that just happens, ``(*B, 2)``.

        exp(−gap/ℓ) and exp(−gap/ℓ'), as in :class:`aicon_torch.parts.ContactLikelihood`.
        """
        gap = self._gap(x_pusher, stop(x_rest))  # stops the gradient, as above
        size = self.contact.size
        reaches = (self.contact.reach * size, self.contact.reaction * size)
        return torch.stack([likelihood_across(gap, reach) for reach in reaches], dim=-1)

    def moved(self, x_rest: Tensor, n_contact: Tensor, p_contact: Tensor) -> Tensor:
        """x_obj: where it comes to rest, moved by the contact to come, ``(*B, 2)``, m.

        The contact gives a gradient s p n and no value. Whether it counts as intended is up to the
        gradient that arrives (:func:`aicon_torch.by_gain`); where it had better be counts always as
        far as an intended one, so that the pusher finds the way around.

        Args:
            x_rest: Where it comes to rest, ``(*B, 2)``, m.
            n_contact: n, along which the pusher would push it, ``(*B, 2)``.
            p_contact: p, as intended and as incidental, ``(*B, 2)``.
        """
        intended, incidental = p_contact.unsqueeze(-2).unbind(-1)
        by_likelihood = by_gain(stop(n_contact).unsqueeze(-2), intended, incidental)
        by_place = stop(intended) * n_contact

        motion = self.contact.step * self.contact.size * (by_likelihood + by_place)
        return x_rest + straight_through(torch.zeros_like(motion), motion)

    @property
    def _slower(self) -> float:
        """μ g, by how much a second slows it down, m/s²."""
        return self.friction * GRAVITY

    def _gap(self, x_pusher: Tensor, place: Tensor) -> Tensor:
        """‖c − x‖ − (R + r), ``(*B,)``, m."""
        return norm(place - x_pusher) - (self.radius + self.pusher_radius)
