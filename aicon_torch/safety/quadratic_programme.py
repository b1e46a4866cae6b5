"""The nearest action that keeps linear bounds: a quadratic programme, in sweeps or exactly."""

import torch
from torch import Tensor

from aicon_torch.differentiation import learns
from aicon_torch.safety.active_set import exactly_within
from aicon_torch.safety.hildreth import sweep, swept_within
from aicon_torch.safety.rows import Rows, SafeAction, SafetyBounds, clamped, joined, normalised

MOST_UNROLLED = 48
"""Where rows are looked at more often, it is one operation, for which there is a routine in C."""

SLACK = 1e-4
"""By how much a bound may be missed, as a share of the widest range of a component: rounding must
not bring a robot to rest."""

GIVES_WAY = 10.0
"""Where no action keeps a row, its gap may close as fast as so many times what the row asks for."""

YIELDING, YIELDING_SWEEPS = 0.05, 100
"""κ, as a share of the longest row, and how many sweeps at least, while something learns. The less
κ is, the less is missed in the end, and the more sweeps it takes to come there."""


def nearest_safe(
    nominal: Tensor,
    within: SafetyBounds,
    sweeps: int | None,
    inverse: Tensor | None = None,
    longest: float | None = None,
    coming: Tensor | None = None,
) -> SafeAction:
    """The action a = argmin (a − w)ᵀM(a − w) with c·a ≥ b for every row, and low ≤ a ≤ high.

    After a fixed number of sweeps the action is drawn back by one factor toward a retreat, the one
    nearest to rest, until it keeps every row as well as the retreat does. Where rest keeps all rows
    (b ≤ 0) it is the retreat, so that the action is safe where the sweeps have not converged. Where
    something comes nearer (b > 0), the retreat gets out of its way; and where no action keeps all
    rows, it is the one that misses least (:func:`_yielding`). What comes nearer pushes nobody
    through what stands still.

    Where the norm of the action is limited, it is drawn back likewise until it is short enough.

    Without a number of sweeps, it is found exactly (:mod:`aicon_torch.safety.active_set`). What no
    action keeps is then asked for as far as the retreat keeps it.

    All leading dimensions broadcast.

    Args:
        nominal: w, ``(*B, n)``.
        within: The bounds.
        sweeps: How many; None for exactly.
        inverse: M⁻¹, ``(*B, n, n)``, symmetric and positive definite; None for M = I.
        longest: L, the largest norm of an action, in its unit; None for any in the box.
        coming: u, how fast each gap closes at rest, since something comes nearer, ``(*B, m)``, in
            its unit a second; None where that is not known, so that anything with b > 0 may come.

    Returns:
        The action and the force of the bounds.
    """
    nominal, within = _of_one_batch(nominal, within, inverse, coming)
    rows, lengths = normalised(within)
    rest = clamped(torch.zeros_like(nominal), within)
    retreat = rest
    if rows.bounds.shape[-1] > 0:
        held = _held(rest, rows, None if coming is None else coming / lengths)
        retreat = _retreat(rest, rows, lengths, held, within, sweeps)
    if longest is not None:
        retreat = _shortened(retreat, torch.zeros_like(retreat), longest)

    # The nearest action, on the safe side of what has not been found exactly.
    asked = rows
    if sweeps is None:
        asked = rows._replace(bounds=rows.bounds + _kept(retreat, rows).clamp(max=0.0))
    action, force = _projected(nominal, asked, within, sweeps, inverse)
    if rows.bounds.shape[-1] > 0:
        action = _drawn_back(action, retreat, rows, within)
    if longest is not None:
        action = _shortened(action, retreat, longest)
    return SafeAction(action, force)


def _of_one_batch(
    nominal: Tensor, within: SafetyBounds, inverse: Tensor | None, coming: Tensor | None
) -> tuple[Tensor, SafetyBounds]:
    """The nominal action and its bounds with the leading dimensions ``*B`` of all there is."""
    vectors = (nominal, within.bounds, within.low, within.high, coming)
    shapes = [vector.shape[:-1] for vector in vectors if vector is not None]
    shapes += [matrix.shape[:-2] for matrix in (within.slopes, inverse) if matrix is not None]
    batch = torch.broadcast_shapes(*shapes)  # type: ignore[no-untyped-call]  # torch leaves it untyped

    slopes, *sides = within
    nominal, *sides = (vector.expand(*batch, -1) for vector in (nominal, *sides))
    return nominal, SafetyBounds(slopes.expand(*batch, -1, -1), *sides)


def _held(rest: Tensor, rows: Rows, coming: Tensor | None) -> Rows:
    """What is asked of each row in any case, h of c·a ≥ h.

    That is b, where rest keeps it. Else it is −u: a gap that something closes may close as much
    faster, but one that has just been missed (b → 0) or to what stands still (u = 0) no further.

    Args:
        rest: Rest, within the box, ``(*B, n)``: 0, unless a component has to move anyway.
        rows: The rows.
        coming: u, ``(*B, m)``, in the action's unit.
    """
    given_way = GIVES_WAY * rows.bounds
    if coming is not None:
        given_way = torch.minimum(given_way, coming)
    held = torch.where(rows.bounds > 0.0, -given_way, rows.bounds)
    of_rest = (rows.normals * rest.unsqueeze(-2)).sum(-1)
    return rows._replace(bounds=torch.minimum(held, of_rest))


def _retreat(
    rest: Tensor,
    rows: Rows,
    lengths: Tensor,
    held: Rows,
    within: SafetyBounds,
    sweeps: int | None,
) -> Tensor:
    """The action near rest that keeps all rows, or else misses least of them, ``(*B, n)``.

    Args:
        rest: Rest, within the box, ``(*B, n)``.
        rows: The rows.
        lengths: What they were divided by, ``(*B, m)``.
        held: What is asked of them in any case.
        within: The bounds, with the box.
        sweeps: How many; None for exactly.
    """
    # One that keeps all rows, if there is one, and one that yields: exactly, unless that is to be
    # differentiated.
    enough = max(sweeps or 0, YIELDING_SWEEPS) if learns() else None
    keeping, _ = _projected(torch.zeros_like(rest), rows, within, enough)
    yielding = _yielding(rows, lengths, held, within, enough)

    # On the safe side of what sweeps have not found: what rest keeps is kept.
    if enough is not None:
        keeping = _drawn_back(keeping, rest, held, within)
        yielding = _drawn_back(yielding, rest, held, within)

    # The yielding one, if it misses less by more than rounding.
    slack = _slack(within) * lengths.amax(-1, keepdim=True)
    missed = _most_missed(yielding, rows, lengths)
    missed_by_keeping = _most_missed(keeping, rows, lengths)
    return torch.where(missed + slack < missed_by_keeping, yielding, keeping)


def _yielding(
    rows: Rows, lengths: Tensor, held: Rows, within: SafetyBounds, sweeps: int | None
) -> Tensor:
    """The action near rest that misses least of the bounds that rest does not keep, ``(*B, n)``.

    Where not all of them can be kept, those of what comes may all be missed by the same speed κs:

        min ‖a‖² + s²  with  c·a + κs ≥ b where h < 0 < b,  and  c·a ≥ h  everywhere,

    the same programme with one component more.

    Args:
        rows: The rows.
        lengths: What they were divided by, ``(*B, m)``.
        held: What is asked of them in any case, h.
        within: The bounds, with the box.
        sweeps: How many.
    """
    yields = (rows.bounds > 0.0) & (held.bounds < 0.0)
    price = torch.where(yields, YIELDING * lengths.amax(-1, keepdim=True) / lengths, 0.0)
    length = (1.0 + price * price).sqrt()
    yielding = torch.cat((rows.normals, price.unsqueeze(-1)), dim=-1) / length.unsqueeze(-1)
    anyway = torch.cat((held.normals, torch.zeros_like(price).unsqueeze(-1)), dim=-1)
    asked = torch.where(yields, rows.bounds, held.bounds) / length
    wider = joined([Rows(yielding, asked), Rows(anyway, held.bounds)])

    nothing = torch.zeros_like(within.low[..., :1])
    anything = nothing + torch.finfo(nothing.dtype).max
    low, high = torch.cat((within.low, nothing), -1), torch.cat((within.high, anything), -1)
    wider_box = SafetyBounds(wider.normals, wider.bounds, low, high)
    found, _ = _projected(torch.zeros_like(low), wider, wider_box, sweeps)
    return found[..., :-1]


def _kept(action: Tensor, rows: Rows) -> Tensor:
    """By how much each row is kept, n·a − b, ``(*B, m)``, in the action's unit."""
    return (rows.normals * action.unsqueeze(-2)).sum(-1) - rows.bounds


def _most_missed(action: Tensor, rows: Rows, lengths: Tensor) -> Tensor:
    """The speed by which the worst row is missed, ``(*B, 1)``, in the gaps' unit a second."""
    return (lengths * (-_kept(action, rows)).clamp(min=0.0)).amax(-1, keepdim=True)


def _projected(
    nominal: Tensor,
    rows: Rows,
    within: SafetyBounds,
    sweeps: int | None,
    inverse: Tensor | None = None,
) -> SafeAction:
    """The nearest action: itself, or as far as some sweeps come."""
    metric = inverse
    if metric is None:
        metric = torch.eye(nominal.shape[-1], dtype=nominal.dtype, device=nominal.device)

    if sweeps is None:
        action, force = exactly_within(nominal, rows, within, metric)
    elif sweeps * rows.bounds.shape[-1] > MOST_UNROLLED and not learns():
        action, force = swept_within(nominal, rows, within, sweeps, metric)
    else:
        action, force = sweep(nominal, rows, within, sweeps, inverse)
    return SafeAction(clamped(action, within), force)


def _slack(within: SafetyBounds) -> Tensor:
    """By how much a row of length one may be missed, ``(*B, 1)``, in the action's unit."""
    return SLACK * (within.high - within.low).amax(-1, keepdim=True)


def _drawn_back(action: Tensor, retreat: Tensor, rows: Rows, within: SafetyBounds) -> Tensor:
    """The action on the way from the retreat that goes farthest and keeps every row."""
    slack = _slack(within)
    closing = -(rows.normals * (action - retreat).unsqueeze(-2)).sum(-1)

    # How much faster than in the retreat each gap may close.
    room = slack + _kept(retreat, rows).clamp(min=0.0)

    exceeds = closing > room
    share = torch.where(exceeds, room / torch.where(exceeds, closing, 1.0), 1.0)
    return retreat + (action - retreat) * share.amin(-1, keepdim=True)


def _shortened(action: Tensor, retreat: Tensor, longest: float) -> Tensor:
    """The action on the way from the retreat that goes farthest and is short enough, ``(*B, n)``.

    ‖r + t(a − r)‖ ≤ L for a share t of the way, the larger root of a quadratic equation. What is
    between two actions keeps all bounds that both of them keep.

    Args:
        action: a, ``(*B, n)``.
        retreat: r, no longer than L, ``(*B, n)``.
        longest: L, in the action's unit.
    """
    way = action - retreat
    square = (way * way).sum(-1, keepdim=True)
    along = (retreat * way).sum(-1, keepdim=True)
    left = (longest**2 - (retreat * retreat).sum(-1, keepdim=True)).clamp(min=0.0)

    tiny = torch.finfo(square.dtype).tiny ** 0.5
    root = (along * along + square * left).clamp(min=tiny).sqrt()
    share = ((root - along) / square.clamp(min=tiny)).clamp(0.0, 1.0)
    return retreat + share * way
