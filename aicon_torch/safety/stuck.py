"""Stalemates: where constraints bring an actuator to rest short of its goals, and the way out."""

import torch
from torch import Tensor

from aicon_torch.dampers import ConstraintEscape
from aicon_torch.resolution import Memory
from aicon_torch.safety import SafeAction
from aicon_torch.safety.task_cost import FollowedCost, is_of_other_goals
from aicon_torch.vectors import unit

# Shares of the cost, and times in the dampers' time constant: a faster robot needs no new number.
PROGRESS = 0.1  # by which the cost must fall, or rise, to count as changed
PATIENCE = 2.0  # for how long it may fail to fall
OPPOSITION = 0.1  # share of the nominal action that the constraints must take away to oppose it

# Of a push along the force.
TRIES = 2  # number of escapes, from the last best cost on, after which the force leads nowhere
BACK = 0.7  # cosine of the angle to the last push reversed, within which a force points back
SHORTEST, LONGEST = 1.5, 15.0  # its duration
DESCENT = 0.5  # share of the climb that must be undone
BLOCKED = 0.05  # share of the actuator's limit below which a motion counts as blocked

# Of a detour.
MIDDLE = 0.5  # share of each component's range, about its middle, that the places are in
DETOUR = 6.0  # where a component has no range, it goes as far as it comes in this time, at most


def initial_escape(size: int) -> Memory:
    """FREE, and nothing was reached yet: what is remembered, without batch dimensions.

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


class WayOut:
    """A way out of where an actuator is held up: while it escapes, it goes in one direction.

    Args:
        limits: Of the actuator, ``(n,)``.
    """

    def __init__(self, limits: Tensor) -> None:
        self.limits = limits

    def aim(self, nominal: Tensor, memory: Memory) -> Tensor:
        """What it tries, ``(*B, n)``: the nominal action, or at full speed what leads out.

        Args:
            nominal: What the goals ask for, ``(*B, n)``.
            memory: What was remembered.
        """
        direction = memory["direction"]
        excess = time_of(direction, self.limits).unsqueeze(-1)
        fastest = direction / excess.clamp(min=torch.finfo(nominal.dtype).tiny ** 0.5)
        return torch.where(memory["escaping"].unsqueeze(-1), fastest, nominal)


class Stalemate(WayOut):
    """Detects that an actuator is held up, and moves it to where its goals are tried anew.

    Three states and what leads from one to another:

    ======  =============================================================  ======
    FREE    a stalemate, and the constraints' force leads out of it        PUSHED
    FREE    a stalemate, and it does not                                   DETOUR
    PUSHED  the crest is passed, the motion is blocked, or 15 T are over   FREE
    DETOUR  the place is reached, or the motion is blocked                 FREE
    any     the goals are other ones                                       FREE
    ======  =============================================================  ======

    In memory, FREE is not `escaping`; PUSHED is `escaping` and `by_force`, DETOUR without it.

    A *stalemate* is that the cost of the goals has not fallen for a while, although the constraints
    oppose the nominal action or the cost has not risen either. (One that comes and goes while
    nothing is in the way is the noise of the readings.)

    PUSHED, the actuator moves along the constraints' force f = Σ μᵢcᵢ, what they add to the nominal
    action to make it the action where all components count alike, in the direction that f had at
    the stalemate. The cost climbs on the way, and the push ends well over the crest, or else the
    actuator would slide back.

    The force leads nowhere where the constraints do not oppose the nominal action, as at a
    singularity, where a few pushes have led to no better cost, and where it points back against the
    last push, as between two stops of one joint. A DETOUR goes straight to a place instead: the
    next of a sequence that fills the middle of the components' ranges evenly.

    Args:
        options: From which cost on the actuator may stay where it is.
        limits: Of the actuator, ``(n,)``.
        dt: The time step, s.
        time: The dampers' time constant, s.
    """

    def __init__(self, options: ConstraintEscape, limits: Tensor, dt: float, time: float) -> None:
        super().__init__(limits)
        self.options, self.time = options, time
        self.step = dt / time

    def judge(
        self,
        cost: FollowedCost,
        nominal: Tensor,
        safe: SafeAction,
        room: tuple[Tensor, Tensor],
        memory: Memory,
    ) -> Memory:
        """Whether to escape from the next step on, and where to.

        Args:
            cost: What the goals cost, here and after a step.
            nominal: What they ask for, ``(*B, n)``.
            safe: What the constraints made of what was tried.
            room: How far each component may go down and up, ``(*B, n)`` both; ∞ for any.
            memory: What was remembered.
        """
        now = cost.at_rest
        clock, highest = memory["clock"] + self.step, torch.maximum(now, memory["highest"])
        is_free = ~memory["escaping"]

        # What counts since the goals are these: the best cost, and escapes that led to no better.
        is_other = is_of_other_goals(cost, memory["before"], self.limits, PROGRESS)
        is_best = is_other | (is_free & _falls(now, memory["best"]))
        tries = torch.where(is_best, 0, memory["tries"])
        escapes = torch.where(is_other, 0, memory["escapes"])

        # From FREE to PUSHED or DETOUR.
        is_opposed = _is_opposed(nominal, safe.action)
        is_held_up = self._is_held_up(now, clock, highest, is_opposed, memory)
        begins = is_free & is_held_up & ~is_other
        force = unit(safe.force)
        leads_out = is_opposed & ~_points_back(force, memory) & (tries < TRIES)
        detour = self._way_to_a_place(escapes, room)
        way_out = torch.where(leads_out.unsqueeze(-1), force, detour)

        # Back to FREE.
        is_blocked = time_of(safe.action, self.limits) < BLOCKED
        is_past = self._is_past_the_crest(cost, safe.action, clock, highest, is_blocked, memory)
        is_there = self._is_there(clock, is_blocked, memory)
        is_over = torch.where(memory["by_force"], is_past, is_there)
        ends = ~is_free & (is_over | is_other)

        # The clock begins anew with every state, with other goals, and with progress.
        restarts = begins | ends | is_other | (is_free & _falls(now, memory["lowest"]))
        return {
            "escaping": (~is_free | begins) & ~ends,
            "by_force": torch.where(begins, leads_out, memory["by_force"] & ~is_other),
            "direction": torch.where(begins.unsqueeze(-1), way_out, memory["direction"]),
            "clock": torch.where(restarts, 0.0, clock),
            "lowest": torch.where(restarts, now, memory["lowest"]),
            "highest": torch.where(restarts, now, highest),
            "best": torch.where(is_best, now, memory["best"]),
            "tries": tries + begins,
            "escapes": escapes + begins,
            "before": now,
        }

    def _is_held_up(
        self, now: Tensor, clock: Tensor, highest: Tensor, is_opposed: Tensor, memory: Memory
    ) -> Tensor:
        """Whether the cost has not fallen for long, for a reason other than noise, ``(*B,)``."""
        is_late = ~_falls(now, memory["lowest"]) & (clock >= PATIENCE)
        is_steady = highest < (1.0 + PROGRESS) * memory["lowest"]
        return is_late & (now > self.options.near) & (is_steady | is_opposed)

    def _is_past_the_crest(
        self,
        cost: FollowedCost,
        action: Tensor,
        clock: Tensor,
        highest: Tensor,
        is_blocked: Tensor,
        memory: Memory,
    ) -> Tensor:
        """Whether a push is over, ``(*B,)``: the climb is undone, or no more of it can be."""
        climb = highest - memory["lowest"]
        is_undone = cost.at_rest < highest - DESCENT * climb
        rises_again = _falls(cost.at_rest, highest) & (cost.fall_along(action) < 0.0)
        may_end = (clock >= SHORTEST) & (is_undone | rises_again | is_blocked)
        return may_end | (clock >= LONGEST)

    def _is_there(self, clock: Tensor, is_blocked: Tensor, memory: Memory) -> Tensor:
        """Whether a detour is over, ``(*B,)``: at its place, or where the motion is blocked."""
        is_at_its_place = clock >= time_of(memory["direction"], self.limits) / self.time
        return is_at_its_place | ((clock >= SHORTEST) & is_blocked)

    def _way_to_a_place(self, number: Tensor, room: tuple[Tensor, Tensor]) -> Tensor:
        """The way to a place in the middle of the ranges, ``(*B, n)``.

        Args:
            number: Which of the sequence of places, ``(*B,)``.
            room: How far each component may go down and up, ``(*B, n)`` both.
        """
        farthest = DETOUR * self.time * self.limits
        down, up = (torch.where(side.isfinite(), side, farthest.to(side) / MIDDLE) for side in room)
        middle, half = (up - down) / 2.0, (up + down) / 2.0
        return middle + MIDDLE * half * spread(number, middle)


def time_of(way: Tensor, limits: Tensor) -> Tensor:
    """How long a way ``(*B, n)`` takes at full speed, ``(*B,)``, s; of a velocity its share."""
    return (way.abs() / limits.to(way)).amax(-1)


def _falls(now: Tensor, before: Tensor) -> Tensor:
    """Whether a cost is less than another by more than noise, ``(*B,)``."""
    return now < (1.0 - PROGRESS) * before


def _points_back(force: Tensor, memory: Memory) -> Tensor:
    """Whether a force of length one leads back along the last push, ``(*B,)``."""
    along = (force * memory["direction"]).sum(-1)
    return memory["by_force"] & (along < -BACK)


def _is_opposed(nominal: Tensor, action: Tensor) -> Tensor:
    """Whether the constraints take away a good share of the nominal action, ``(*B,)``."""
    opposition = ((nominal - action) * nominal).sum(-1)
    return opposition > OPPOSITION * (nominal * nominal).sum(-1)


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
