"""A search for a place at which the goals are reached, while the actuator moves."""

from typing import NamedTuple

import torch
from torch import Tensor

from aicon_torch.resolution import Memory
from aicon_torch.safety.task_cost import FollowedCost

FALLS = 0.03  # share by which the cost of an imagined place must fall to count as lower
HOPELESS = 5  # steps in a row without that, after which another one is imagined
LEAP = 0.4  # way of a step at most, in the action's unit times s


def initial_search(size: int) -> Memory:
    """No place is known: what is remembered, without batch dimensions.

    Args:
        size: Number n of components of the actuator.
    """
    return {
        "knows": torch.tensor(False),
        "known": torch.zeros(size),
        "sought": torch.zeros(size),  # the first one begins where the actuator is
        "sought_cost": torch.tensor(torch.inf),
        "hopeless": torch.tensor(0),
        "places": torch.tensor(0),
    }


class Found(NamedTuple):
    """What is imagined after a step of the search; places as ways from here.

    Attributes:
        knows: Whether a place is known, ``(*B,)``.
        known: The nearest one, ``(*B, n)``.
        sought: The one that is being improved, ``(*B, n)``.
        cost: The least that it has cost, ``(*B,)``.
        hopeless: For how many steps that has not fallen, ``(*B,)``.
        is_done: Whether it is given up or has been taken over, ``(*B,)``.
    """

    knows: Tensor
    known: Tensor
    sought: Tensor
    cost: Tensor
    hopeless: Tensor
    is_done: Tensor


class PlaceSearch:
    """Improves two imagined places: the nearest that is known, and the next of a sequence.

    The model says at present what the goals would cost if the actuator were elsewhere, G(x), and
    in which direction they fall. A step goes where they would cost nothing if they went on so
    (Polyak 1969), not far at a time and not beyond the ranges of the components:

        x ← x − G ∇G/‖∇G‖².

    For the pose of a tip this is damped least squares, an inverse kinematics in the background, a
    step of it in a step of the robot. A place is known once the goals are reached there and no
    gap is closed; of two the one that is nearer remains. It goes on being improved, so that it
    follows a target that moves, and is no longer known where a gap closes at it.

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
        ways = torch.stack((memory["known"], memory["sought"]))
        here, gradient = cost.slope(ways / self.dt)
        slope = gradient / self.dt
        square = (slope * slope).sum(-1, keepdim=True)
        step = -here.unsqueeze(-1) * slope / square.clamp(min=torch.finfo(square.dtype).tiny ** 0.5)
        longest = step.abs().amax(-1, keepdim=True).clamp(min=LEAP)
        down, up = room
        improved = torch.minimum(torch.maximum(ways + step * (LEAP / longest), -down), up)

        # Which of them is known from now on.
        is_reached = here < self.near
        is_good = is_reached & (cost.of_safety(ways / self.dt) <= 0.0)
        is_known, is_new = is_good.unbind()
        is_known = is_known & memory["knows"]
        times = (ways.abs() / self.limits.to(ways)).amax(-1)
        takes_over = is_new & (~is_known | (times[1] < times[0]))

        is_lower = here[1] < (1.0 - FALLS) * memory["sought_cost"]
        hopeless = torch.where(is_lower, 0, memory["hopeless"] + 1)
        return Found(
            knows=is_known | takes_over,
            known=torch.where(takes_over.unsqueeze(-1), improved[1], improved[0]),
            sought=improved[1],
            cost=torch.minimum(here[1], memory["sought_cost"]),
            hopeless=hopeless,
            is_done=is_reached[1] | (hopeless >= HOPELESS),
        )

    def remembered(self, found: Found, number: Tensor, next_way: Tensor, moved: Tensor) -> Memory:
        """What is remembered of it; the next place of the sequence where one is done with.

        Args:
            found: What was found.
            number: Of the next place, ``(*B,)``.
            next_way: The way to it, ``(*B, n)``.
            moved: How far the actuator moves in this step, ``(*B, n)``.
        """
        is_done = found.is_done
        sought = torch.where(is_done.unsqueeze(-1), next_way, found.sought)
        largest = torch.finfo(found.cost.dtype).max
        return {
            "knows": found.knows,
            "known": found.known - moved,
            "sought": sought - moved,
            "sought_cost": torch.where(is_done, largest, found.cost),
            "hopeless": torch.where(is_done, 0, found.hopeless),
            "places": number + is_done,
        }
