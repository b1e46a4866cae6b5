"""The nearest action that keeps linear bounds: a quadratic programme, in sweeps or exactly."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import torch
from torch import Tensor

from aicon_torch.differentiation import learns
from aicon_torch.errors import OptionError
from aicon_torch.safety.active_set import exactly

MOST_UNROLLED = 48
"""Where rows are looked at more often, it is one operation, for which there is a routine in C."""

SLACK = 1e-4
"""By how much a bound may be missed, as a share of the widest range of a component: rounding must
not bring a robot to rest."""

YIELDING, YIELDING_SWEEPS = 0.05, 100
"""κ, as a share of the longest row, and how many sweeps at least. The less κ is, the less is
missed in the end, and the more sweeps it takes to come there."""


class SafetyBounds(NamedTuple):
    """Bounds on an action: how fast each gap may close, and how far each component may go.

    Attributes:
        slopes: c, by how much each gap grows a second and per unit of the action, ``(*B, m, n)``.
        bounds: b, ``(*B, m)``, in the gaps' unit a second: c·a ≥ b. At most 0 where rest is safe.
        low: The least of each component, ``(*B, n)``, in the action's unit.
        high: The largest, likewise.
    """

    slopes: Tensor
    bounds: Tensor
    low: Tensor
    high: Tensor


class SafeAction(NamedTuple):
    """What came out.

    Attributes:
        action: a, ``(*B, n)``.
        force: f = Σ μᵢcᵢ, of the bounds' multipliers, ``(*B, n)``. What the bounds add to the
            nominal action is f, or M⁻¹f in a metric M.
    """

    action: Tensor
    force: Tensor


def nearest_safe(
    nominal: Tensor, within: SafetyBounds, sweeps: int | None, inverse: Tensor | None = None
) -> SafeAction:
    """The action a = argmin (a − w)ᵀM(a − w) with c·a ≥ b for every row, and low ≤ a ≤ high.

    After a fixed number of sweeps the action is drawn back by one factor toward a retreat, the one
    nearest to rest that came out likewise, until it keeps every row as well as the retreat does.
    Where rest keeps all rows (b ≤ 0) it is the retreat, so that the action is safe where the sweeps
    have not converged. Where something comes nearer (b > 0), the retreat gets out of its way; and
    where no action keeps all rows, it is the one that misses least (:func:`_yielding`).

    Args:
        nominal: w, ``(*B, n)``.
        within: The bounds.
        sweeps: How many; None for the action itself (:mod:`aicon_torch.safety.active_set`).
        inverse: M⁻¹, ``(*B, n, n)``, symmetric and positive definite; None for M = I.

    Returns:
        The action and the force of the bounds.
    """
    rows, lengths = _normalised(within)
    if rows.bounds.shape[-1] == 0:
        return _projected(nominal, rows, within, sweeps, inverse)

    retreat, _ = _projected(torch.zeros_like(nominal), rows, within, sweeps)
    enough = None if sweeps is None else max(sweeps, YIELDING_SWEEPS)
    yielding = _yielding(rows, lengths, within, enough)
    slack = _slack(within) * lengths.amax(-1, keepdim=True)  # no choice hangs on rounding
    missed = _most_missed(yielding, rows, lengths)
    missed_at_rest = _most_missed(retreat, rows, lengths)
    retreat = torch.where(missed + slack < missed_at_rest, yielding, retreat)

    asked = rows
    if sweeps is None:  # what no action keeps is asked for as far as the retreat keeps it
        asked = rows._replace(bounds=rows.bounds + _kept(retreat, rows).clamp(max=0.0))
    action, force = _projected(nominal, asked, within, sweeps, inverse)
    return SafeAction(_drawn_back(action, retreat, rows, within), force)


class _Rows(NamedTuple):
    """Rows of length one: n·a ≥ b.

    Attributes:
        normals: n, ``(*B, m, n)``.
        bounds: b, ``(*B, m)``, in the action's unit.
    """

    normals: Tensor
    bounds: Tensor


def _yielding(rows: _Rows, lengths: Tensor, within: SafetyBounds, sweeps: int | None) -> Tensor:
    """The action near rest that misses least of the bounds that rest does not keep, ``(*B, n)``.

    Where not all of them can be kept, they may all be missed by the same speed κs:

        min ‖a‖² + s²  with  c·a + κs ≥ b where b > 0,  c·a ≥ b elsewhere,

    the same programme with one component more. What stands still is kept.

    Args:
        rows: The rows.
        lengths: What they were divided by, ``(*B, m)``.
        within: The bounds, with the box.
        sweeps: How many.
    """
    price = YIELDING * lengths.amax(-1, keepdim=True) / lengths
    price = torch.where(rows.bounds > 0.0, price, 0.0)
    length = (1.0 + price * price).sqrt()
    wider = _Rows(
        normals=torch.cat((rows.normals, price.unsqueeze(-1)), dim=-1) / length.unsqueeze(-1),
        bounds=rows.bounds / length,
    )

    nothing = torch.zeros_like(within.low[..., :1])
    anything = nothing + torch.finfo(nothing.dtype).max
    low, high = torch.cat((within.low, nothing), -1), torch.cat((within.high, anything), -1)
    wider_box = SafetyBounds(wider.normals, wider.bounds, low, high)
    found, _ = _projected(torch.zeros_like(low), wider, wider_box, sweeps)
    return found[..., :-1]


def _kept(action: Tensor, rows: _Rows) -> Tensor:
    """By how much each row is kept, n·a − b, ``(*B, m)``, in the action's unit."""
    return (rows.normals * action.unsqueeze(-2)).sum(-1) - rows.bounds


def _most_missed(action: Tensor, rows: _Rows, lengths: Tensor) -> Tensor:
    """The speed by which the worst row is missed, ``(*B, 1)``, in the gaps' unit a second."""
    return (lengths * (-_kept(action, rows)).clamp(min=0.0)).amax(-1, keepdim=True)


def _projected(
    nominal: Tensor,
    rows: _Rows,
    within: SafetyBounds,
    sweeps: int | None,
    inverse: Tensor | None = None,
) -> SafeAction:
    """The nearest action, as far as the sweeps converge; without a number of them, itself.

    Hildreth's method (1957): one row after the other is satisfied by the least change, and what an
    earlier sweep changed too much is taken back. The least change for a row n is along M⁻¹n, and
    brings n·a forward by nᵀM⁻¹n.
    """
    identity = torch.eye(nominal.shape[-1], dtype=nominal.dtype, device=nominal.device)
    metric = identity if inverse is None else inverse
    if sweeps is None:
        _check_not_learning()
        boxed = _with_box(rows, within, identity)
        found = exactly(nominal, boxed.normals, boxed.bounds, metric)
        action, force = found.chunk(2, dim=-1)
    elif sweeps * rows.bounds.shape[-1] > MOST_UNROLLED and not learns():
        of_rows = (rows.normals, rows.bounds, _effects_of(rows, metric))
        found = swept(nominal, *of_rows, within.low, within.high, metric, sweeps)
        action, force = found.chunk(2, dim=-1)
    else:
        effects = None if inverse is None else _effects_of(rows, inverse)
        action, force = _sweep(nominal, rows, effects, within, sweeps, inverse)
    return SafeAction(_clamped(action, within), force)


def _check_not_learning() -> None:
    """Check that nothing is to be learned through a solver that is no function of torch.

    Raises:
        OptionError: If something is.
    """
    if learns():
        raise OptionError(
            "dampers.sweeps=None: gradients do not go through the exact solver. To learn through "
            "time, give a number of sweeps, such as 12."
        )


def _with_box(rows: _Rows, within: SafetyBounds, identity: Tensor) -> _Rows:
    """The rows, and the sides of the box as rows."""
    sides = torch.cat((identity, -identity)).expand(*rows.normals.shape[:-2], -1, -1)
    limits = torch.cat((within.low, -within.high), dim=-1).expand(*rows.bounds.shape[:-1], -1)
    return _Rows(torch.cat((rows.normals, sides), dim=-2), torch.cat((rows.bounds, limits), dim=-1))


def _effects_of(rows: _Rows, inverse: Tensor) -> Tensor:
    """By how much a change along M⁻¹n brings n·a forward, nᵀM⁻¹n, ``(*B, m)``; 1 for a row of 0."""
    effects = (rows.normals @ inverse * rows.normals).sum(-1)
    return effects.where(effects > 0.0, 1.0)


def _sweep(
    nominal: Tensor,
    rows: _Rows,
    effects: Tensor | None,
    within: SafetyBounds,
    sweeps: int,
    inverse: Tensor | None,
    until_still: bool = False,
) -> tuple[Tensor, Tensor]:
    """The action and the force of the bounds after some sweeps, ``(*B, n)`` both.

    Args:
        nominal: w.
        rows: The rows.
        effects: nᵀM⁻¹n, ``(*B, m)``; None for M = I.
        within: The bounds, with the box.
        sweeps: How many.
        inverse: M⁻¹; None for M = I.
        until_still: Whether to stop where a sweep has changed nothing.
    """
    normal_of, bound_of = rows.normals.unbind(-2), rows.bounds.unbind(-1)
    change_of: Sequence[Tensor] = normal_of
    effect_of: Sequence[float | Tensor] = (1.0,) * len(normal_of)
    if inverse is not None and effects is not None:
        change_of, effect_of = (rows.normals @ inverse).unbind(-2), effects.unbind(-1)

    action, push = nominal, torch.zeros_like(nominal)
    multipliers = [torch.zeros_like(bound) for bound in bound_of]
    for _ in range(sweeps):
        before = action

        # Each row: the least multiplier ≥ 0 that satisfies it.
        for index, normal in enumerate(normal_of):
            missing = bound_of[index] - (normal * action).sum(-1)
            multiplier = (multipliers[index] + missing / effect_of[index]).clamp(min=0.0)
            more = multiplier - multipliers[index]
            action = action + more.unsqueeze(-1) * change_of[index]
            multipliers[index] = multiplier

        # The box is the last one, and pushes each component by a multiplier of its own.
        action, push = _into_box(action, push, within, inverse)
        if until_still and torch.equal(action, before):
            break

    force = push
    for normal, multiplier in zip(normal_of, multipliers, strict=True):
        force = force + multiplier.unsqueeze(-1) * normal
    return action, force


@torch.library.custom_op("aicon::swept", mutates_args=())
def swept(
    nominal: Tensor,
    normals: Tensor,
    bounds: Tensor,
    effects: Tensor,
    low: Tensor,
    high: Tensor,
    inverse: Tensor,
    sweeps: int,
) -> Tensor:
    """The sweeps of Hildreth's method in a metric, of any number of rows.

    Args:
        nominal: w, ``(*B, n)``.
        normals: n, ``(*B, m, n)``.
        bounds: b, ``(*B, m)``.
        effects: nᵀM⁻¹n, ``(*B, m)``.
        low: The least of each component, ``(*B, n)``.
        high: The largest.
        inverse: M⁻¹, ``(*B, n, n)``.
        sweeps: How many.

    Returns:
        The action and the force of the bounds, one after the other, ``(*B, 2 n)``.
    """
    within = SafetyBounds(normals, bounds, low, high)
    rows = _Rows(normals, bounds)
    found = _sweep(nominal, rows, effects, within, sweeps, inverse, until_still=True)
    return torch.cat(found, dim=-1)


@swept.register_fake
def _(nominal: Tensor, *_: Any) -> Tensor:
    return nominal.new_empty((*nominal.shape[:-1], 2 * nominal.shape[-1]))


def _into_box(
    action: Tensor, push: Tensor, within: SafetyBounds, inverse: Tensor | None
) -> tuple[Tensor, Tensor]:
    """The action within the box, and what pushes it there now, ``(*B, n)`` both.

    Args:
        action: a.
        push: What pushed it there in the sweep before, and is taken back.
        within: The bounds, with the box.
        inverse: M⁻¹; None for M = I.
    """
    if inverse is None:
        free = action - push
        kept = _clamped(free, within)
        return kept, kept - free

    # In a metric a push of one component moves the others as well: one after the other.
    sides = zip(within.low.unbind(-1), within.high.unbind(-1), strict=True)
    pushes = list(push.unbind(-1))
    for index, (low, high) in enumerate(sides):
        effect = inverse[..., index, index]
        free = action[..., index] - pushes[index] * effect
        needed = (torch.minimum(torch.maximum(free, low), high) - free) / effect
        action = action + (needed - pushes[index]).unsqueeze(-1) * inverse[..., index]
        pushes[index] = needed
    return action, torch.stack(pushes, dim=-1)


def _clamped(action: Tensor, within: SafetyBounds) -> Tensor:
    """The nearest action in the box where all components count alike."""
    return torch.minimum(torch.maximum(action, within.low), within.high)


def _slack(within: SafetyBounds) -> Tensor:
    """By how much a row of length one may be missed, ``(*B, 1)``, in the action's unit."""
    return SLACK * (within.high - within.low).amax(-1, keepdim=True)


def _normalised(within: SafetyBounds) -> tuple[_Rows, Tensor]:
    """Rows of length one, and what they were divided by, ``(*B, m)``.

    Those that no action changes ask for nothing.
    """
    lengths = torch.linalg.vector_norm(within.slopes, dim=-1)
    matters = lengths > torch.finfo(lengths.dtype).eps

    divisor = torch.where(matters, lengths, 1.0)
    normals = torch.where(matters.unsqueeze(-1), within.slopes / divisor.unsqueeze(-1), 0.0)
    bounds = torch.where(matters, within.bounds / divisor, -1.0)
    return _Rows(normals, bounds), divisor


def _drawn_back(action: Tensor, retreat: Tensor, rows: _Rows, within: SafetyBounds) -> Tensor:
    """The action on the way from the retreat that goes farthest and keeps every row."""
    slack = _slack(within)
    closing = -(rows.normals * (action - retreat).unsqueeze(-2)).sum(-1)

    # How much faster than in the retreat each gap may close.
    room = slack + _kept(retreat, rows).clamp(min=0.0)

    exceeds = closing > room
    share = torch.where(exceeds, room / torch.where(exceeds, closing, 1.0), 1.0)
    return retreat + (action - retreat) * share.amin(-1, keepdim=True)
