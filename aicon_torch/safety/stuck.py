"""Stalemates: where constraints bring an actuator to rest short of its goals, and the way out."""

import torch
from torch import Tensor

from aicon_torch.dampers import ConstraintEscape
from aicon_torch.resolution import Memory
from aicon_torch.safety import SafeAction
from aicon_torch.safety.task_cost import FollowedCost
from aicon_torch.vectors import unit

JUMP = 2.0
"""A cost that grows by more than so many steps at full speed is that of other goals."""


def initial_escape(size: int) -> Memory:
    """Not escaping, and nothing was reached yet: what is remembered, without batch dimensions.

    Args:
        size: Number n of components of the actuator.
    """
    return {
        "escaping": torch.tensor(False),
        "by_force": torch.tensor(False),
        "direction": torch.zeros(size),
        "clock": torch.tensor(0.0),
        "lowest": torch.tensor(torch.inf),
        "highest": torch.tensor(0.0),
        "best": torch.tensor(torch.inf),
        "tries": torch.tensor(0),
        "escapes": torch.tensor(0),
        "before": torch.tensor(torch.inf),
    }


class Stalemate:
    """Detects that an actuator is held up, and moves it along the constraints' force.

    See :class:`aicon_torch.dampers.ConstraintEscape`.

    Args:
        options: When an escape begins and ends.
        limits: Of the actuator, ``(n,)``.
        dt: The time step, s.
        time: The dampers' time constant, s.
    """

    def __init__(self, options: ConstraintEscape, limits: Tensor, dt: float, time: float) -> None:
        self.options, self.limits, self.time = options, limits, time
        self.step = dt / time

    def aim(self, wish: Tensor, memory: Memory) -> Tensor:
        """What the actuator tries, ``(*B, n)``: the wish, or at full speed what leads out.

        Args:
            wish: What the goals wish for, ``(*B, n)``.
            memory: What was remembered.
        """
        direction = memory["direction"]
        excess = (direction.abs() / self.limits.to(wish)).amax(-1, keepdim=True)
        fastest = direction / excess.clamp(min=torch.finfo(wish.dtype).tiny ** 0.5)
        return torch.where(memory["escaping"].unsqueeze(-1), fastest, wish)

    def judge(
        self,
        cost: FollowedCost,
        wish: Tensor,
        safe: SafeAction,
        room: tuple[Tensor, Tensor],
        memory: Memory,
    ) -> Memory:
        """Whether to escape from the next step on, and where to.

        Args:
            cost: What the goals cost, here and after a step.
            wish: What they wish for, ``(*B, n)``.
            safe: What the constraints made of what was tried.
            room: How far each component may go down and up, ``(*B, n)`` both; ∞ for any.
            memory: What was remembered.
        """
        now, share = cost.at_rest, 1.0 - self.options.progress
        was_escaping, clock = memory["escaping"], memory["clock"] + self.step

        # Begin where the cost has not fallen for long; end over the crest.
        falls = now < share * memory["lowest"]
        is_stuck = ~falls & (clock >= self.options.patience) & (now > self.options.near)

        # What comes and goes while nothing opposes it is noise: the actuator is where it can be.
        highest = torch.maximum(now, memory["highest"])
        is_steady = highest < (1.0 + self.options.progress) * memory["lowest"]
        is_opposed = self._is_opposed(wish, safe.action)
        begins = ~was_escaping & is_stuck & (is_steady | is_opposed)
        is_out = self._is_out(cost, safe.action, clock, highest, memory)

        # A cost that grows by more than a step can do is that of other goals: all begins anew.
        limits, before = self.limits.to(wish), memory["before"]
        by_motion = JUMP * cost.steepness(limits) * torch.linalg.vector_norm(limits)
        is_other = now > before + torch.maximum(by_motion, self.options.progress * before)
        begins = begins & ~is_other
        ends = was_escaping & (is_out | is_other)

        # Every escape without a new best cost is one more try.
        is_best = is_other | (~was_escaping & (now < share * memory["best"]))
        tries = torch.where(is_best, 0, memory["tries"])
        force = unit(safe.force)
        leads_on = ~self._points_back(force, memory)
        by_force = is_opposed & leads_on & (tries < self.options.forced)
        escapes = torch.where(is_other, 0, memory["escapes"])
        detour = self._way_to_a_place(escapes, room)
        way_out = torch.where(by_force.unsqueeze(-1), force, detour)

        # The clock begins anew with every escape, attempt and progress.
        restarts = begins | ends | is_other | (~was_escaping & falls)
        return {
            "escaping": (was_escaping | begins) & ~ends,
            "by_force": torch.where(begins, by_force, memory["by_force"] & ~is_other),
            "direction": torch.where(begins.unsqueeze(-1), way_out, memory["direction"]),
            "clock": torch.where(restarts, 0.0, clock),
            "lowest": torch.where(restarts, now, memory["lowest"]),
            "highest": torch.where(restarts, now, highest),
            "best": torch.where(is_best, now, memory["best"]),
            "tries": tries + begins,
            "escapes": escapes + begins,
            "before": now,
        }

    def _is_out(
        self, cost: FollowedCost, action: Tensor, clock: Tensor, highest: Tensor, memory: Memory
    ) -> Tensor:
        """Whether an escape is over, ``(*B,)``."""
        options, now, entry = self.options, cost.at_rest, memory["lowest"]
        is_undone = now < highest - options.descent * (highest - entry)
        is_past_crest = now < (1.0 - options.progress) * highest
        rises_again = is_past_crest & (cost.fall_along(action) < 0.0)
        is_blocked = (action.abs() / self.limits.to(action)).amax(-1) < options.blocked

        may_end = (clock >= options.shortest) & (is_undone | rises_again | is_blocked)
        by_force = may_end | (clock >= options.longest)

        # A detour is over at its place, or where the motion is blocked.
        way = (memory["direction"].abs() / self.limits.to(action)).amax(-1)  # s, at full speed
        is_there = clock >= way / self.time
        is_stopped = (clock >= options.shortest) & is_blocked
        return torch.where(memory["by_force"], by_force, is_there | is_stopped)

    def _way_to_a_place(self, number: Tensor, room: tuple[Tensor, Tensor]) -> Tensor:
        """The way to a place in the middle of the ranges, ``(*B, n)``.

        Args:
            number: Which of the sequence of places, ``(*B,)``.
            room: How far each component may go down and up, ``(*B, n)`` both.
        """
        share, farthest = self.options.middle, self.options.detour * self.time * self.limits
        down, up = (torch.where(side.isfinite(), side, farthest.to(side) / share) for side in room)
        middle, half = (up - down) / 2.0, (up + down) / 2.0
        return middle + share * half * spread(number, middle)

    def _points_back(self, force: Tensor, memory: Memory) -> Tensor:
        """Whether a force of length one leads back along the last escape by a force, ``(*B,)``."""
        along = (force * memory["direction"]).sum(-1)
        return memory["by_force"] & (along < -self.options.back)

    def _is_opposed(self, wish: Tensor, action: Tensor) -> Tensor:
        """Whether the constraints take away a good share of the wish, ``(*B,)``."""
        opposition = ((wish - action) * wish).sum(-1)
        return opposition > self.options.opposition * (wish * wish).sum(-1)


def spread(index: Tensor, like: Tensor) -> Tensor:
    """Number i of a sequence of directions that fills [−1, 1]ⁿ evenly, ``(*B, n)``.

    Component j is 2·frac(½ + (i + 1) φ⁻ʲ⁻¹) − 1, where φ is the positive root of xⁿ⁺¹ = x + 1 (the
    additive recurrence R of Roberts 2018).

    Args:
        index: i, ``(*B,)``.
        like: What has n components.
    """
    size = like.shape[-1]
    root = 2.0
    for _ in range(50):
        root = (1.0 + root) ** (1.0 / (size + 1))

    steps = like.new_tensor([root ** -(component + 1) for component in range(size)])
    return 2.0 * torch.remainder(0.5 + (index.unsqueeze(-1) + 1) * steps, 1.0) - 1.0
