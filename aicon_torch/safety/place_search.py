"""A search for a place at which the goals are reached, while the actuator moves."""

from typing import NamedTuple

import torch
from torch import Tensor

from aicon_torch.resolution import Memory
from aicon_torch.safety.known_places import Known, first_of
from aicon_torch.safety.task_cost import FollowedCost

FALLS = 0.03  # share by which the cost of an imagined place must fall to count as lower
HOPELESS = 5  # steps in a row without that, after which another one is imagined
LEAP = 0.4  # way of a step at most, in the action's unit times s
KEPT = 4  # places that are known at most
IMAGINED = 4  # places that are improved at a time


def initial_search(size: int) -> Memory:
    """No place is known: what is remembered, without batch dimensions.

    Args:
        size: Number n of components of the actuator.
    """
    # One begins where the actuator is; the others have nothing to fall to, and begin at places.
    is_one = torch.arange(IMAGINED) == 0
    return {
        "knows": torch.zeros(KEPT, dtype=torch.bool),
        "known": torch.zeros(KEPT, size),
        "tries": torch.zeros(KEPT),
        "sought": torch.zeros(IMAGINED, size),
        "sought_cost": torch.where(is_one, torch.inf, 0.0),
        "hopeless": torch.where(is_one, 0, HOPELESS),
        "places": torch.tensor(0),
    }


class Found(NamedTuple):
    """What is imagined after a step of the search; places as ways from here.

    Attributes:
        known: The places that are known.
        sought: Those that are being improved, ``(m, *B, n)``.
        cost: The least that each has cost, ``(m, *B)``.
        hopeless: For how many steps that has not fallen, ``(m, *B)``.
        is_done: Whether it is given up or has been taken over, ``(m, *B)``.
    """

    known: Known
    sought: Tensor
    cost: Tensor
    hopeless: Tensor
    is_done: Tensor


class PlaceSearch:
    """Improves imagined places: those that are known, and the next ones of a sequence.

    The model says at present what the goals would cost if the actuator were elsewhere, G(x), and
    in which direction they fall. A step goes where they would cost nothing if they went on so
    (Polyak 1969), not far at a time and not beyond the ranges of the components:

        x ← x − G ∇G/‖∇G‖².

    For the pose of a tip this is damped least squares, an inverse kinematics in the background, a
    step of it from each of several postures in a step of the robot. A place is known once the goals
    are reached there and no gap is closed. It goes on being improved, so that it follows a target
    that moves. For gaps that are closed one place is looked at in each step: a new one, or else the
    one that leads, which is no longer known where one closes at it.

    Args:
        limits: Of the actuator, ``(n,)``.
        near: The cost below which the goals are reached.
        dt: The time step, s.
    """

    def __init__(self, limits: Tensor, near: float, dt: float) -> None:
        self.limits, self.near, self.dt = limits, near, dt

    def __call__(self, cost: FollowedCost, room: tuple[Tensor, Tensor], memory: Memory) -> Found:
        """A step of the search.

        Args:
            cost: What the goals cost elsewhere.
            room: How far each component may go down and up, ``(*B, n)`` both; ∞ for any.
            memory: What was remembered.
        """
        known, sought = (memory[name].movedim(-2, 0) for name in ("known", "sought"))
        here, improved = self._improved(cost, torch.cat((known, sought)), room)
        is_reached = here < self.near
        listed = Known(
            is_place=memory["knows"].movedim(-1, 0) & is_reached[: len(known)],
            ways=known,
            tries=memory["tries"].movedim(-1, 0),
        )

        # One place is looked at: the first new one that is reached, or else the one that leads.
        is_next = first_of(is_reached[len(known) :])
        is_new = is_next.any(0)
        is_head = listed.head(self.limits) & ~is_new
        looked_at = (sought * is_next.unsqueeze(-1)).sum(0) + (known * is_head.unsqueeze(-1)).sum(0)
        is_clear = cost.of_safety(looked_at / self.dt) <= 0.0
        new = (improved[len(known) :] * is_next.unsqueeze(-1)).sum(0)
        remaining = Known(
            is_place=listed.is_place & (is_clear | ~is_head),
            ways=improved[: len(known)],
            tries=listed.tries,
        )

        # Which of those that are sought are done with: what is reached waits until it is looked at.
        least, waited = (memory[name].movedim(-1, 0) for name in ("sought_cost", "hopeless"))
        own = here[len(known) :]
        hopeless = torch.where(own < (1.0 - FALLS) * least, 0, waited + 1)
        return Found(
            known=remaining.with_one(new, is_new & is_clear, self.limits),
            sought=improved[len(known) :],
            cost=torch.minimum(own, least),
            hopeless=hopeless,
            is_done=is_next | (hopeless >= HOPELESS),
        )

    def _improved(
        self, cost: FollowedCost, ways: Tensor, room: tuple[Tensor, Tensor]
    ) -> tuple[Tensor, Tensor]:
        """What the goals cost at places ``(m, *B, n)``, and these a step further down."""
        here, gradient = cost.slope(ways / self.dt)
        slope = gradient / self.dt
        square = (slope * slope).sum(-1, keepdim=True)
        step = -here.unsqueeze(-1) * slope / square.clamp(min=torch.finfo(square.dtype).tiny ** 0.5)
        longest = step.abs().amax(-1, keepdim=True).clamp(min=LEAP)
        down, up = room
        return here, torch.minimum(torch.maximum(ways + step * (LEAP / longest), -down), up)

    def remembered(self, found: Found, number: Tensor, next_ways: Tensor, moved: Tensor) -> Memory:
        """What is remembered of it; the next places of the sequence where some are done with.

        Args:
            found: What was found.
            number: Of the next place, ``(*B,)``.
            next_ways: The ways to the next ones, for each that is sought, ``(m, *B, n)``.
            moved: How far the actuator moves in this step, ``(*B, n)``.
        """
        is_done = found.is_done
        sought = torch.where(is_done.unsqueeze(-1), next_ways, found.sought)
        largest = torch.finfo(found.cost.dtype).max
        return {
            "knows": found.known.is_place.movedim(0, -1),
            "known": (found.known.ways - moved).movedim(0, -2),
            "tries": found.known.tries.movedim(0, -1),
            "sought": (sought - moved).movedim(0, -2),
            "sought_cost": torch.where(is_done, largest, found.cost).movedim(0, -1),
            "hopeless": torch.where(is_done, 0, found.hopeless).movedim(0, -1),
            "places": number + is_done.sum(0),
        }
