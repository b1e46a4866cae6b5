"""Safety goals at an actuator: how fast gaps may close, and the nearest action that keeps to it."""

import math
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from functools import cache

import torch
from torch import Tensor

from aicon_torch.dampers import PlaceEscape, WayAround
from aicon_torch.differentiation import hop_from, literal, pull
from aicon_torch.errors import GraphError, choices
from aicon_torch.goals import Goal
from aicon_torch.graph import WorldModel
from aicon_torch.interconnections import copied
from aicon_torch.resolution import Memory
from aicon_torch.safety import SafeAction, SafetyBounds, nearest_safe
from aicon_torch.safety.places import Places, initial_places
from aicon_torch.safety.probing import (
    check_gaps,
    is_box,
    is_going_on,
    probe_values,
    read_by_gaps,
    without_rounding,
)
from aicon_torch.safety.rows import Rows, clamped, joined
from aicon_torch.safety.task_cost import FollowedCost
from aicon_torch.safety.way_around import Around, initial_way

FARTHEST = 1e9
"""A gap larger than this, in its unit, may close at any speed: there may be no limit at all."""

NEGLIGIBLE = 1e-6
"""A change of a gap, in its unit, or in its unit a second, that counts as none."""


class ActuatorSafety:
    """What keeps the safety goals at one actuator (see :class:`aicon_torch.Goal`).

    The gaps are anticipated one step ahead of the values, as functions of the action; how they grow
    with it are the rows. What moves by itself is in them as the model foresees it. Actuators that
    share a goal share what its gaps may close: each keeps to an equal part, wherever the others go.

    Args:
        model: The world model.
        actuator: Name of the actuator.
        goals: The safety goals that depend on it.
        sharing: For each of them all actuators on which it depends.

    Raises:
        GraphError: If the actuator has no finite limit, a goal has no gaps, or its gaps go on
            changing when the actuator is at rest.
    """

    def __init__(
        self,
        model: WorldModel,
        actuator: str,
        goals: list[Goal],
        sharing: Mapping[str, Sequence[str]],
    ) -> None:
        declared = model.actuators[actuator]
        limits = torch.as_tensor(declared.limit, dtype=torch.float64, device="cpu").expand(
            declared.size
        )
        if not limits.isfinite().all():
            raise GraphError(
                f"Actuator {actuator!r} has limit={declared.limit!r}: the safety goal "
                f"{goals[0].name!r} needs a finite one."
            )

        self.model, self.actuator, self.goals = model, actuator, goals
        self.sharing = sharing
        self.limits = limits
        is_norm = isinstance(declared.limit, float) and declared.size > 1
        self.longest = float(limits[0]) if is_norm else None
        self.time = declared.dampers.braking / float(limits.median())
        self.sweeps = declared.dampers.sweeps
        self.haste = declared.dampers.haste
        self._upstream = {goal.name: _upstream(model, goal.inputs) for goal in goals}
        self._moved_on = {
            name: _moved_on(model, sharing[name], upstream)
            for name, upstream in self._upstream.items()
        }
        self._boxed: list[str] = []
        self._still: dict[str, int] = {}
        values = probe_values(model)
        for goal in goals:
            slopes, _, gaps = self.rows_of(goal, values)
            check_gaps(goal, gaps, slopes)
            self._check_comes_to_rest(goal, values)

            # Gaps that no action changes are to crowd out none; of many, they are left out before.
            still = int((~self.moves(slopes)).all(0).sum())
            self._still[goal.name] = 0 if goal.has_many_gaps else still
            if is_box(slopes):
                self._boxed.append(goal.name)
        self._ranged = [goal for goal in goals if goal.name in self._boxed and goal.has_room]

        escape = declared.dampers.escape
        self.stalemate: Places | Around | None = None
        if isinstance(escape, PlaceEscape):
            self.stalemate = Places(escape, limits, model.dt)
        elif escape is not None:
            self.stalemate = Around(limits, model.dt, self.time)

    def __call__(
        self,
        values: Mapping[str, Tensor],
        nominal: Tensor,
        memory: Mapping[str, Tensor],
        goal_factors: Tensor,
    ) -> tuple[Tensor, Memory]:
        """The action that keeps the safety goals.

        Args:
            values: Values after the new readings.
            nominal: The nominal action: what the other goals ask for, within the constraints of the
                actuator, ``(*B, n)``.
            memory: The memory before the step.
            goal_factors: Factor of each goal, ``(*B, goals)``.

        Returns:
            The action ``(*B, n)``, and what is remembered of it.
        """
        within, coming, known = self.bounds(values, goal_factors)
        inverse = self._inverse_metric(values)

        def nearest(action: Tensor) -> SafeAction:
            """The action nearest to one that keeps the bounds."""
            return nearest_safe(action, within, self.sweeps, inverse, self.longest, coming)

        wanted = nominal
        if self.haste != 1.0:
            wanted = self._constrained(values, self.haste * nominal)
        if self.stalemate is None:
            return torch.where(known, nearest(wanted).action, 0.0), {}

        # While escaping, the direction of the escape stands for the nominal action, and serves no
        # goal: all components count alike.
        start = f"{self.actuator}/escape/"
        own = {key[len(start) :]: value for key, value in memory.items() if key.startswith(start)}
        if inverse is not None:
            escaping = own["escaping"][..., None, None]
            identity = torch.eye(nominal.shape[-1], dtype=inverse.dtype, device=inverse.device)
            inverse = torch.where(escaping, identity, inverse)
        if isinstance(self.stalemate, Places):
            aim = self._constrained(values, self.stalemate.aim(wanted, own), on_detour=True)
        else:
            aim = self._constrained(values, self.stalemate.aim(nominal, own))
        safe = nearest(aim)
        action = self.model.actuators[self.actuator].clip(safe.action)  # against rounding

        if isinstance(self.stalemate, Around):
            remembered = self.stalemate.judge(nominal, aim, safe, own)
        else:
            cost = FollowedCost(self.model, self.actuator, values, goal_factors)
            allowed, room = action, self._room(values)
            action = _unless_escaping(cost.not_beyond(allowed), allowed, within, own)
            remembered = self.stalemate.judge(cost, nominal, allowed, action, room, own)

        # Where nobody knows what bounds it, nothing moves.
        action = torch.where(known, action, 0.0)
        return action, {start + key: value for key, value in remembered.items()}

    def _constrained(
        self, values: Mapping[str, Tensor], action: Tensor, on_detour: bool = False
    ) -> Tensor:
        """An action within the constraints of the actuator, ``(*B, n)``."""
        return self.model.constrain(self.actuator, {**values, self.actuator: action}, on_detour)

    def _inverse_metric(self, values: Mapping[str, Tensor]) -> Tensor | None:
        """M⁻¹ of the actuator's metric, ``(*B, n, n)``; None where all components count alike."""
        metric = self.model.metric(self.actuator, values)
        if metric is None:
            return None
        identity = torch.eye(metric.shape[-1], dtype=metric.dtype, device=metric.device)
        inverse: Tensor = torch.linalg.solve_ex(metric, identity.expand_as(metric)).result
        return inverse

    def _room(self, values: Mapping[str, Tensor]) -> tuple[Tensor, Tensor]:
        """How far each component may go down and up, ``(*B, n)`` both; ∞ where nothing says it."""
        down = torch.full_like(values[self.actuator], torch.inf)
        up = down
        for goal in self._ranged:
            to_low, to_high = goal.room(self._now(goal, values))
            down, up = torch.minimum(down, to_low), torch.minimum(up, to_high)
        return down, up

    def bounds(
        self, values: Mapping[str, Tensor], goal_factors: Tensor
    ) -> tuple[SafetyBounds, Tensor, Tensor]:
        """What all goals ask of the action, and its limits.

        Args:
            values: Values after the new readings.
            goal_factors: Factor of each goal, ``(*B, goals)``; one that is off asks for nothing.

        Returns:
            The bounds; how fast the gap of each row closes at rest, ``(*B, m)``; and in which rows
            of the batch all of them are numbers, ``(*B, 1)``.
        """
        names = list(self.model.goals)
        at_rest = torch.zeros_like(values[self.actuator])
        high = at_rest + self.limits.to(at_rest)
        low = -high
        nothing = Rows(at_rest.unsqueeze(-2)[..., :0, :], at_rest[..., :0])
        rows, sides, coming = [nothing], [nothing], [nothing.bounds]
        known = torch.ones_like(at_rest[..., :1], dtype=torch.bool)

        # A goal's rows; one that is off, or that the action cannot serve, gets a bound that never
        # holds anything up.
        for goal in self.goals:
            is_box = goal.name in self._boxed
            most = None if is_box else goal.most_gaps + self._still[goal.name]
            slope, bound, gaps = self.rows_of(goal, values, most)
            is_on = goal_factors[..., names.index(goal.name), None] != 0

            # What is no number bounds nothing, and says nothing either.
            is_known = (gaps + bound + slope.sum(-1)).isfinite().all(-1, keepdim=True)
            known = known & (is_known | ~is_on)
            counts = is_on & (is_box | self.moves(slope))  # what cannot give way is no bound
            closing = (bound - self._asked_at(gaps, goal)).clamp(min=0.0)
            bound = torch.where(counts, bound, -FARTHEST / self.model.dt)
            if is_box:
                sides.append(Rows(slope, bound))
            else:
                rows.append(Rows(slope, bound))
                coming.append(closing)

        # Joint stops and the like narrow the box of the limits; all else are rows.
        if self._boxed:
            low, high = _narrowed(low, high, joined(sides))
        return SafetyBounds(*joined(rows), low, high), torch.cat(coming, dim=-1), known

    def rows_of(
        self, goal: Goal, values: Mapping[str, Tensor], most: int | None = None
    ) -> tuple[Tensor, Tensor, Tensor]:
        """The rows c·a ≥ b of a goal's smallest gaps.

        One step ahead a gap is d⁺(a) ≈ d⁺(0) + (∂d⁺/∂a)·a, and shall be e^(−dt/T) d or more, so

            c = (∂d⁺/∂a)/dt,   b = (e^(−dt/T) d − d⁺(0))/dt,

        and of b the k-th part where k actuators share the goal, all of them at rest in d⁺(0).

        Args:
            goal: The goal.
            values: Values after the new readings.
            most: So many gaps at most; None for all.

        Returns:
            c ``(*B, m, n)``, b ``(*B, m)`` and the gaps ``(*B, m)``.
        """
        gaps = goal.gaps(self._now(goal, values)).clamp(max=FARTHEST)
        gaps = torch.where(gaps.isnan(), -torch.inf, gaps)  # the smallest, which no bound keeps
        count = gaps.shape[-1] if most is None else min(most, gaps.shape[-1])
        smallest = gaps.topk(count, dim=-1, largest=False).indices

        gaps = gaps.gather(-1, smallest)
        least = math.exp(-self.model.dt / self.time) * gaps
        at_rest, slopes = self._ahead(goal, values, smallest)
        own_part = (least - at_rest) / len(self.sharing[goal.name])
        return slopes / self.model.dt, own_part / self.model.dt, gaps

    def _asked_at(self, gaps: Tensor, goal: Goal) -> Tensor:
        """What b is where nothing moves by itself, (e^(−dt/T) − 1) d/dt, ``(*B, m)``."""
        own_part = math.expm1(-self.model.dt / self.time) * gaps / len(self.sharing[goal.name])
        return own_part / self.model.dt

    def _now(self, goal: Goal, values: Mapping[str, Tensor]) -> Mapping[str, Tensor]:
        """The values before the action, for a goal: some have moved on by the last one already."""
        if not self._moved_on[goal.name]:
            return values
        now = self._at_rest(goal, values)
        for name in self._moved_on[goal.name]:
            now[name] = self.model.owners[name](now, name)
        return now

    def _at_rest(self, goal: Goal, values: Mapping[str, Tensor]) -> dict[str, Tensor]:
        """The values, with the actuators that share a goal at rest."""
        resting = {name: torch.zeros_like(values[name]) for name in self.sharing[goal.name]}
        return {**values, **resting}

    def _ahead(
        self, goal: Goal, values: Mapping[str, Tensor], which: Tensor
    ) -> tuple[Tensor, Tensor]:
        """Some gaps ``(*B, m)`` after a step at rest, and their slopes by the action.

        A backward pass yields one derivative for each row of a batch, so each gap gets a copy of
        the values of its own.

        Returns:
            d⁺(0) ``(*B, m)`` and ∂d⁺/∂a ``(*B, m, n)``.
        """
        copies = copied(values, which.shape[-1])
        gap_of_copy = which.movedim(-1, 0)

        with torch.enable_grad(), literal():
            resting = self._at_rest(goal, copies)
            action = resting[self.actuator].requires_grad_()
            ahead = self._foreseen(goal, resting)  # every estimate once, for all gaps
            gaps = goal.gap(ahead, gap_of_copy).clamp(max=FARTHEST)
            slopes: Tensor | None = None
            if gaps.requires_grad:
                (slopes,) = pull(gaps.sum(), action, allow_unused=True)
        if slopes is None:
            raise GraphError(
                f"Safety goal {goal.name!r}: its gaps do not depend on the actuator "
                f"{self.actuator!r}, so that no action could keep them. They read "
                f"{choices(goal.inputs)}."
            )

        at_rest = hop_from(gaps)  # a bound is a number
        return at_rest.movedim(0, -1), slopes.movedim(0, -2)

    def _foreseen(self, goal: Goal, values: Mapping[str, Tensor]) -> dict[str, Tensor]:
        """The values with those on which a goal depends one step ahead."""
        foreseen = dict(values)
        for name in self._upstream[goal.name]:
            foreseen[name] = self.model.owners[name](foreseen, name)
        return foreseen

    def moves(self, slopes: Tensor) -> Tensor:
        """Which gaps an action can change, by their slopes ``(*B, m, n)``, ``(*B, m)``."""
        change = self.time * (slopes.abs() * self.limits.to(slopes)).sum(-1)
        return change > NEGLIGIBLE

    def _check_comes_to_rest(self, goal: Goal, values: Mapping[str, Tensor]) -> None:
        """Check that a goal's gaps come to rest with the actuator, as those of velocities do.

        Raises:
            GraphError: If they go on changing by themselves.
        """

        def after(action: Tensor) -> tuple[Tensor, Tensor]:
            """The gaps after a step with an action, and after one more at rest."""
            once = self._foreseen(goal, {**self._at_rest(goal, values), self.actuator: action})
            twice = self._foreseen(goal, self._at_rest(goal, once))
            return goal.gaps(once), goal.gaps(twice)

        with torch.no_grad():
            fastest = self.limits.to(values[self.actuator]).expand_as(values[self.actuator])
            moved, coasted = after(fastest)
            stayed, drifted = after(torch.zeros_like(fastest))
        if is_going_on(moved - stayed, (coasted - moved) - (drifted - stayed)):
            raise GraphError(
                f"Safety goal {goal.name!r}: its gaps go on changing when {self.actuator!r} is "
                "back at rest, as where an action is an acceleration or a force. It bounds how "
                "fast gaps close, so let the action be a velocity, and Actuator(command=) make of "
                "it what the robot is sent."
            )


def _unless_escaping(
    shortened: Tensor, action: Tensor, within: SafetyBounds, memory: Memory
) -> Tensor:
    """A shortened action ``(*B, n)``, unless a detour is made or a gap has to grow faster."""
    shortened = clamped(shortened, within)
    is_taken = ~memory["escaping"]
    if within.bounds.shape[-1] > 0:
        speeds = (within.slopes * shortened.unsqueeze(-2)).sum(-1)
        is_taken = is_taken & (speeds >= within.bounds - NEGLIGIBLE).all(-1)
    return torch.where(is_taken.unsqueeze(-1), shortened, action)


def _narrowed(low: Tensor, high: Tensor, sides: Rows) -> tuple[Tensor, Tensor]:
    """A box within which rows hold that depend on one component each, ``(*B, n)`` both.

    Should one depend on several after all, each of them gets an equal share of its bound. Where two
    rows cannot both hold, none is missed by more than at rest.
    """
    largest = torch.finfo(low.dtype).max
    slopes = without_rounding(sides.normals)
    components = (slopes != 0).sum(-1).clamp(min=1)
    shares = (sides.bounds / components).unsqueeze(-1)
    ratios = shares / torch.where(slopes == 0, 1.0, slopes)
    from_below = torch.where(slopes > 0, ratios, -largest).amax(-2)
    from_above = torch.where(slopes < 0, ratios, largest).amin(-2)

    # A side that asks for a motion asks for no more than the other one allows.
    from_below, from_above = (
        torch.minimum(from_below, from_above.clamp(min=0.0)),
        torch.maximum(from_above, from_below.clamp(max=0.0)),
    )

    # What is beyond a gap comes back as fast as it may.
    lowest = torch.minimum(torch.maximum(low, from_below), high)
    highest = torch.maximum(torch.minimum(high, from_above), lowest)
    return lowest, highest


def safety_of(model: WorldModel) -> dict[str, ActuatorSafety]:
    """What keeps the safety goals, for each actuator on which one of them depends."""
    found = _safety_goals(model)
    sharing: defaultdict[str, list[str]] = defaultdict(list)
    for actuator, goals in found.items():
        for goal in goals:
            sharing[goal.name].append(actuator)
    return {
        actuator: ActuatorSafety(model, actuator, goals, sharing)
        for actuator, goals in found.items()
    }


def safety_memory(model: WorldModel) -> Memory:
    """What is remembered of escapes before the first step, without batch dimensions."""
    memory: Memory = {}
    for name in _safety_goals(model):
        actuator = model.actuators[name]
        escape = actuator.dampers.escape
        if isinstance(escape, WayAround):
            remembered = initial_way(actuator.size)
        elif escape is not None:
            remembered = initial_places(actuator.size, escape)
        else:
            continue
        memory |= {f"{name}/escape/{key}": value for key, value in remembered.items()}
    return memory


def _safety_goals(model: WorldModel) -> dict[str, list[Goal]]:
    """The safety goals that depend on each actuator on which one of them does."""
    leading = {name: _led_to(model, name) for name in model.actuators}
    found: defaultdict[str, list[Goal]] = defaultdict(list)
    for goal in model.goals.values():
        if not goal.safety:
            continue

        # One alone has to keep all gaps; of several, those on whose quantities no gap depends none.
        actuators = [name for name in leading if goal.name in leading[name]]
        if len(actuators) > 1:
            read = read_by_gaps(goal, probe_values(model))
            actuators = [name for name in actuators if read & leading[name]] or actuators
        for name in actuators:
            found[name].append(goal)
    return {name: found[name] for name in model.actuators if name in found}


def _led_to(model: WorldModel, actuator: str) -> set[str]:
    """The goals and quantities from which a gradient leads to an actuator, itself included."""

    @cache
    def leads(name: str) -> bool:
        return name == actuator or any(leads(edge.source) for edge in model.edges.get(name, ()))

    return {name for name in (actuator, *model.edges) if leads(name)}


def _upstream(model: WorldModel, inputs: tuple[str, ...]) -> tuple[str, ...]:
    """The estimates on which some quantities depend, themselves included, in order of the step."""
    needed = set(inputs)
    found: list[str] = []
    for estimator in reversed(model.estimators):
        own = [name for name in estimator.outputs if name in needed]
        if own:
            found.extend(reversed(own))
            needed.update(estimator.inputs)
    return tuple(reversed(found))


def _moved_on(
    model: WorldModel, actuators: Iterable[str], upstream: tuple[str, ...]
) -> tuple[str, ...]:
    """Those of some estimates, in order, that have no memory and follow from actions at once."""
    moved = set(actuators)
    for name in upstream:
        owner = model.owners[name]
        if not owner.recursive and moved.intersection(owner.inputs):
            moved.add(name)
    return tuple(name for name in upstream if name in moved)
