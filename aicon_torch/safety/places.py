"""Places: where constraints bring an actuator to rest, it goes elsewhere and tries again."""

import math
from typing import NamedTuple

import torch
from torch import Tensor

from aicon_torch.dampers import PlaceEscape
from aicon_torch.resolution import Memory
from aicon_torch.safety.known_places import time_of
from aicon_torch.safety.look_ahead import LookAhead, initial_look
from aicon_torch.safety.nearest import initial_nearest, nearest_so_far
from aicon_torch.safety.place_search import KEPT, Found, PlaceSearch, initial_search
from aicon_torch.safety.task_cost import FollowedCost, is_of_other_goals

# Shares of the cost; and ways that an actuator at its limit a goes in a time: w/a, so that a faster
# robot needs no new number.
PROGRESS = 0.03  # by which the cost must fall to count as lower
UNSTEADY = 0.1  # by which it must rise, meanwhile, to come and go
OPPOSED = 0.1  # share of the nominal action that the constraints must take away to oppose it
STOP = 0.06  # how near to its stop a component is held up there, in its own unit
MIDDLE = 0.5  # share of a range, about its middle, that the places of most components are in
ARRIVED = 0.4  # how near to a place is near enough
LONGEST = 3.75  # w of the longest way to a place; twice as far to one that is known
SLOW = 0.2  # share of the limit below which a motion counts as blocked
BLOCKED = 0.15  # w of how long it must be that
OTHER = 0.1  # by which a cost must jump, at least, to be that of other goals


def initial_places(size: int, options: PlaceEscape) -> Memory:
    """FREE, and no stop is known: what is remembered, without batch dimensions.

    Args:
        size: Number n of components of the actuator.
        options: Whether a place is sought, and whether it ever gives up.
    """
    remembered = {
        "escaping": torch.tensor(False),
        "direction": torch.zeros(size),
        "place": torch.zeros(size),
        "stops": torch.zeros(size),
        "clock": torch.tensor(0.0),
        "slow": torch.tensor(0.0),
        "lowest": torch.tensor(torch.inf),
        "highest": torch.tensor(0.0),
        "escapes": torch.tensor(0),
        "blind": torch.tensor(0),
        "to_known": torch.tensor(False),
        "before": torch.tensor(torch.inf),
    }

    if options.seeks:
        remembered |= initial_search(size)
    if options.looks_ahead:
        remembered |= initial_look()
    if options.gives_up is not None:
        remembered |= initial_nearest(size)
    return remembered


class Turn(NamedTuple):
    """To go elsewhere.

    Attributes:
        begins: Whether it does, ``(*B,)``.
        to_known: Whether to a place that is known, ``(*B,)``.
        place: Where to, ``(*B, n)``.
    """

    begins: Tensor
    to_known: Tensor
    place: Tensor


class Detour(NamedTuple):
    """How a detour goes on.

    Attributes:
        left: What is left to go of a component without a range, ``(*B, n)``.
        slow: For how long it has been blocked, ``(*B,)``.
        is_over: Whether it is: there, blocked, or late, ``(*B,)``.
        fails: Whether it led to a known place and is over before its end, ``(*B,)``.
    """

    left: Tensor
    slow: Tensor
    is_over: Tensor
    fails: Tensor


class Places:
    """Detects that an actuator is held up, and moves it to another place.

    =======  ==========================================  ======================================
    state    what happens                                next state
    =======  ==========================================  ======================================
    FREE     held up                                     DETOUR, to a known place or the next
    FREE     held up once too often                      DETOUR, to where the cost was least
    DETOUR   there, blocked, or late                     FREE
    DETOUR   to the next: a place becomes known          DETOUR, to that one
    DETOUR   to a known one: over before it is there     DETOUR, to another
    any      the goals are other ones                    FREE, and all is forgotten
    =======  ==========================================  ======================================

    FREE, the nominal action is tried. It is held up where the cost of the goals has not fallen by
    3 % for a while, although the constraints oppose the nominal action or the cost is steady. (One
    that comes and goes while nothing is in the way is the noise of the readings.) Then it makes a
    DETOUR at full speed, in the same bounds, to a place at which the goals are reached, of those
    that its search knows (:class:`aicon_torch.safety.place_search.PlaceSearch`), or else to the
    next of a sequence that fills the ranges of the components evenly; it ends near the place, where
    the motion is blocked, or after some time, and the goals are tried anew.

    *Which place.* The known one that was tried least often, and of these the nearest; after as many
    as are kept one of the sequence. It turns to one that becomes known on its way to a place of the
    sequence, if that was the next because none was known. From the way to a known one, which is
    blocked where it no longer gets shorter, it turns to the next.

    *A look ahead*, an option: places of the sequence that are not open are passed over
    (:class:`aicon_torch.safety.look_ahead.LookAhead`), and those that are have their turn sooner:
    the first after as many known ones as are kept, each other after one.

    *Memory of stops.* Where a component is at its stop when it is held up, the branch that led
    there was the wrong one, as that of a wrist: from then on its places are on the other side of
    its middle. Where the goals are other ones, all is forgotten.

    *Giving up*, an option: after so many places it goes to where the cost was least
    (:mod:`aicon_torch.safety.nearest`), and stays.

    Args:
        options: How patient it is, and where it goes.
        limits: Of the actuator, ``(n,)``.
        dt: The time step, s.
    """

    def __init__(self, options: PlaceEscape, limits: Tensor, dt: float) -> None:
        self.options, self.limits = options, limits
        self.dt, self.step = dt, dt * float(limits.median())
        first, last = options.whole
        share = torch.full_like(limits, MIDDLE)
        share[:first] = 1.0
        share[max(len(limits) - last, 0) :] = 1.0
        self.share = share
        self.search = PlaceSearch(limits, options.near, dt)

    def aim(self, nominal: Tensor, memory: Memory) -> Tensor:
        """What it tries, ``(*B, n)``: the nominal action, or at full speed the way to its place.

        Args:
            nominal: What the goals ask for, ``(*B, n)``.
            memory: What was remembered.
        """
        way = memory["direction"]
        time = time_of(way, self.limits).unsqueeze(-1)
        fastest = way / time.clamp(min=torch.finfo(nominal.dtype).tiny ** 0.5)
        return torch.where(memory["escaping"].unsqueeze(-1), fastest, nominal)

    def judge(
        self,
        cost: FollowedCost,
        nominal: Tensor,
        allowed: Tensor,
        action: Tensor,
        room: tuple[Tensor, Tensor],
        memory: Memory,
    ) -> Memory:
        """Whether to go elsewhere from the next step on, and where to.

        Args:
            cost: What the goals cost, here and after a step.
            nominal: What they ask for, ``(*B, n)``.
            allowed: What the constraints made of what was tried, ``(*B, n)``.
            action: What is done of it, ``(*B, n)``.
            room: How far each component may go down and up, ``(*B, n)`` both; ∞ for any.
            memory: What was remembered.
        """
        # Where the goals are other ones, all is forgotten.
        now, is_free = cost.at_rest, ~memory["escaping"]
        is_other = is_of_other_goals(cost, memory["before"], self.limits, OTHER)
        memory = memory | self._forgotten(is_other, memory)

        # FREE, until it is held up; on a DETOUR, until that is over.
        clock, highest = memory["clock"] + self.step, torch.maximum(now, memory["highest"])
        is_lower = is_free & (now < (1.0 - PROGRESS) * memory["lowest"])
        is_late = ~is_lower & (clock >= self.options.patience) & (now > self.options.near)
        is_steady = highest < (1.0 + UNSTEADY) * memory["lowest"]
        is_held_up = is_late & (is_steady | _is_opposed(nominal, allowed)) & is_free & ~is_other
        detour = self._detour(action, clock, room, memory)

        # Where it goes then: to the next place of the sequence, to a known one, or back.
        stops = self._stops(is_held_up, room, memory)
        number = self.next_number(memory)
        following = self._place(number, stops)
        turn = Turn(is_held_up, torch.zeros_like(is_held_up), following)

        more: Memory = {}  # of what is an option
        if self.options.seeks:
            turn, found = self._turn(turn, detour, cost, room, memory)
            more |= self._searched(found, action, room, stops, memory)
        if self.options.gives_up is not None:
            gave_up = ~is_other & (memory["gave_up"] | (turn.begins & self._is_last(memory)))
            more |= nearest_so_far(now, is_other, self.dt * action, gave_up, memory)
            turn = self._last_turn(turn, now, room, memory)

        begins = turn.begins & ~is_other
        if self.options.looks_ahead:
            ahead = self._ahead(cost, number, following, room, memory)
            more |= ahead.remembered(begins & ~turn.to_known)

        # The next state, and since when the cost counts.
        ends = (detour.is_over | (~is_free & is_other)) & ~begins
        restarts = begins | ends | is_other | is_lower
        return {
            **self._next_state(turn._replace(begins=begins), ends, detour, room, memory),
            "stops": stops,
            "clock": torch.where(restarts, 0.0, clock),
            "lowest": torch.where(restarts, now, memory["lowest"]),
            "highest": torch.where(restarts, now, highest),
            "before": now,
            **more,
        }

    def _forgotten(self, is_other: Tensor, memory: Memory) -> Memory:
        """Stops and counts of places: none where the goals are other ones ``(*B,)``."""
        counts = ("escapes", "blind", "ahead")
        forgotten = {key: torch.where(is_other, 0, memory[key]) for key in counts if key in memory}
        return forgotten | {"stops": torch.where(is_other.unsqueeze(-1), 0.0, memory["stops"])}

    def _stops(self, is_held_up: Tensor, room: tuple[Tensor, Tensor], memory: Memory) -> Tensor:
        """At which stop each component is, −1 low and 1 high, or was last, ``(*B, n)``."""
        known = memory["stops"]
        if not self.options.remembers:
            return known

        down, up = room
        at_low = torch.where(down < STOP, -1.0, known)
        stops = torch.where(up < STOP, 1.0, at_low)
        return torch.where(is_held_up.unsqueeze(-1), stops, known)

    def _detour(
        self, action: Tensor, clock: Tensor, room: tuple[Tensor, Tensor], memory: Memory
    ) -> Detour:
        """How its detour goes on.

        Args:
            action: What is done, ``(*B, n)``.
            clock: For how long it has been on it, ``(*B,)``.
            room: How far each component may go down and up, ``(*B, n)`` both; ∞ for any.
            memory: What was remembered.
        """
        # There, ...
        left = memory["direction"] - self.dt * action
        way = _way(memory["place"], room, left)
        is_there = way.abs().amax(-1) < ARRIVED

        # ... blocked, where the way to a known place no longer gets shorter, or nothing moves, ...
        nearer = time_of(memory["direction"], self.limits) - time_of(way, self.limits)
        is_stalled = memory["to_known"] & (nearer < SLOW * self.dt)
        is_slow = is_stalled | (time_of(action, self.limits) < SLOW)
        slow = torch.where(is_slow & memory["escaping"], memory["slow"] + self.step, 0.0)

        # ... or late.
        longest = torch.where(memory["to_known"], 2.0 * LONGEST, LONGEST)
        is_over = memory["escaping"] & (is_there | (slow >= BLOCKED) | (clock >= longest))
        return Detour(left, slow, is_over, fails=is_over & memory["to_known"] & ~is_there)

    def _next_state(
        self,
        turn: Turn,
        ends: Tensor,
        detour: Detour,
        room: tuple[Tensor, Tensor],
        memory: Memory,
    ) -> Memory:
        """The next state, and its way: a turn, or a detour that goes on or ends ``(*B,)``."""
        begins, to_known = turn.begins, turn.to_known
        place = torch.where(begins.unsqueeze(-1), turn.place, memory["place"])
        left = torch.where(begins.unsqueeze(-1), math.pi * turn.place, detour.left)
        return {
            "escaping": (memory["escaping"] | begins) & ~ends,
            "direction": _way(place, room, left),
            "place": place,
            "slow": torch.where(begins, 0.0, detour.slow),
            "escapes": memory["escapes"] + begins,
            "blind": memory["blind"] + (begins & ~to_known),
            "to_known": torch.where(begins, to_known, memory["to_known"]),
        }

    def _ahead(
        self,
        cost: FollowedCost,
        number: Tensor,
        place: Tensor,
        room: tuple[Tensor, Tensor],
        memory: Memory,
    ) -> LookAhead:
        """What is known of the next place of the sequence after a look at it.

        Args:
            cost: What the goals cost elsewhere.
            number: Of the place, ``(*B,)``.
            place: The place, ``(*B, n)``.
            room: How far each component may go down and up, ``(*B, n)`` both; ∞ for any.
            memory: What was remembered.
        """
        ahead = LookAhead(number, _way(place, room, math.pi * place), memory["look"])
        return ahead.after(cost.of_safety(ahead.looked_at / self.dt) <= 0.0)

    def _is_due(self, memory: Memory) -> Tensor:
        """Whether a known place may be the next, ``(*B,)``."""
        is_blind, blind = memory["escaping"] & ~memory["to_known"], memory["blind"]
        blind_before = blind - is_blind.to(blind)
        return memory["escapes"] - blind < self._turns_of_known(blind_before)

    def _turns_of_known(self, blind: Tensor) -> Tensor:
        """How many known places have their turns before the next one of the sequence, ``(*B,)``.

        As many as are kept for each of the sequence; where these are looked at before, as many for
        the first of them, and one for each other.

        Args:
            blind: How often it went to a place of the sequence, ``(*B,)``.
        """
        return KEPT + blind if self.options.looks_ahead else KEPT * (1 + blind)

    def _turn(
        self,
        turn: Turn,
        detour: Detour,
        cost: FollowedCost,
        room: tuple[Tensor, Tensor],
        memory: Memory,
    ) -> tuple[Turn, Found]:
        """Where it goes if it goes elsewhere, and when it does so in the midst of a detour.

        Args:
            turn: To the next place of the sequence where it is held up.
            detour: How its detour goes on.
            cost: What the goals cost, here and after a step.
            room: How far each component may go down and up, ``(*B, n)`` both; ∞ for any.
            memory: What was remembered.

        Returns:
            Where it goes, and what the search knows.
        """
        found = self.search(cost, room, memory)
        head = found.known.head(self.limits)
        way = (found.known.ways * head.unsqueeze(-1)).sum(0)
        to_known = head.any(0) & self._is_due(memory)

        # In the midst of a detour: to one that has become known, or on from one that fails.
        is_blind = memory["escaping"] & ~memory["to_known"]
        begins = turn.begins | (is_blind & to_known) | detour.fails
        place = torch.where(to_known.unsqueeze(-1), _place_at(way, room), turn.place)

        tried = found.known.tries + (head & begins & to_known)
        known = found.known._replace(tries=tried)
        return Turn(begins, to_known, place), found._replace(known=known)

    def _searched(
        self,
        found: Found,
        action: Tensor,
        room: tuple[Tensor, Tensor],
        stops: Tensor,
        memory: Memory,
    ) -> Memory:
        """What is remembered of the search, whose next places may be anywhere in the ranges."""
        numbers = memory["places"] + found.is_done.cumsum(0) - 1
        following = _mirrored(spread(numbers, stops), stops)
        next_ways = _way(following, room, math.pi * following)
        return self.search.remembered(found, memory["places"], next_ways, self.dt * action)

    def _is_last(self, memory: Memory) -> Tensor:
        """Whether it has been to all the places to which it may go, ``(*B,)``."""
        assert self.options.gives_up is not None
        return memory["escapes"] >= self.options.gives_up

    def _last_turn(
        self, turn: Turn, now: Tensor, room: tuple[Tensor, Tensor], memory: Memory
    ) -> Turn:
        """Back to where the cost was least, once it has been to all its places; there it stays.

        Args:
            turn: Where it would go otherwise.
            now: The cost, ``(*B,)``.
            room: How far each component may go down and up, ``(*B, n)`` both; ∞ for any.
            memory: What was remembered.
        """
        is_last = self._is_last(memory)
        is_nearest = now < (1.0 + PROGRESS) * memory["nearest"]
        stays = is_last & (is_nearest | memory["escaping"])
        nearest = _place_at(memory["nearest_way"], room)
        return Turn(
            begins=turn.begins & ~stays,
            to_known=turn.to_known | is_last,
            place=torch.where(is_last.unsqueeze(-1), nearest, turn.place),
        )

    def first_to(self, number: Tensor, memory: Memory) -> Memory:
        """A memory that goes to a place of the sequence before anything else, and then on from it.

        On its way it turns to no place that it knows. Its first step, toward a place as if it were
        in the middle of all ranges, tells it the way.

        Args:
            number: Which place, ``(*B,)``.
            memory: What was remembered.
        """
        place, nothing = self._place(number, memory["stops"]), torch.zeros_like(memory["clock"])

        begun = {
            "escaping": torch.ones_like(memory["escaping"]),
            "direction": math.pi * place,
            "place": place,
            "clock": nothing,
            "slow": nothing,
            "escapes": number + 1 + self._turns_of_known(number),  # which they had
            "blind": number + 1,
            "to_known": torch.zeros_like(memory["to_known"]),
        }
        if self.options.looks_ahead:
            begun["ahead"] = number + 1

        return memory | begun

    def next_number(self, memory: Memory) -> Tensor:
        """The number of the next place of the sequence, ``(*B,)``."""
        return memory["ahead" if self.options.looks_ahead else "escapes"]

    def _place(self, number: Tensor, stops: Tensor) -> Tensor:
        """A place of the sequence, ``(*B, n)``: on the side that is left of a component's stop."""
        return _mirrored(self.share.to(stops) * spread(number, stops), stops)


def _mirrored(place: Tensor, stops: Tensor) -> Tensor:
    """A place ``(*B, n)`` on the side that is left of each component's stop."""
    return torch.where(stops != 0, -stops * place.abs(), place)


def _way(place: Tensor, room: tuple[Tensor, Tensor], left: Tensor) -> Tensor:
    """The way to a place, which is a share of the half range about the middle, ``(*B, n)``.

    A component without a range has no middle: it moves by so much of half a turn.

    Args:
        place: The place, ``(*B, n)``.
        room: How far each component may go down and up, ``(*B, n)`` both; ∞ for any.
        left: What is left to go of one without a range, ``(*B, n)``.
    """
    down, up = room
    is_ranged = down.isfinite() & up.isfinite()
    down, up = (torch.where(is_ranged, side, 0.0) for side in room)
    return torch.where(is_ranged, (up - down) / 2.0 + place * (up + down) / 2.0, left)


def _place_at(way: Tensor, room: tuple[Tensor, Tensor]) -> Tensor:
    """The place to which a way leads: the inverse of :func:`_way`, ``(*B, n)``."""
    down, up = room
    is_ranged = down.isfinite() & up.isfinite()
    down, up = (torch.where(is_ranged, side, math.pi) for side in room)
    return (2.0 * way + torch.where(is_ranged, down - up, 0.0)) / (up + down)


def _is_opposed(nominal: Tensor, action: Tensor) -> Tensor:
    """Whether the constraints take away a good share of the nominal action, ``(*B,)``."""
    opposition = ((nominal - action) * nominal).sum(-1)
    return opposition > OPPOSED * (nominal * nominal).sum(-1)


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
    added = 0.5 + (index.unsqueeze(-1) + 1) * steps
    return 2.0 * (added - added.floor()) - 1.0
