"""The action nearest to a wish that keeps linear bounds: a quadratic programme in fixed sweeps."""

from typing import NamedTuple

import torch
from torch import Tensor

SLACK = 1e-4
"""By how much a bound may be missed, as a share of the widest range of a component: rounding must
not bring a robot to rest."""


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
        force: f = Σ μᵢcᵢ, of the bounds' multipliers, ``(*B, n)``. What the bounds add to the wish
            is f, or M⁻¹f in a metric M.
    """

    action: Tensor
    force: Tensor


def nearest_safe(
    wish: Tensor, within: SafetyBounds, sweeps: int, inverse: Tensor | None = None
) -> SafeAction:
    """The action a = argmin (a − w)ᵀM(a − w) with c·a ≥ b for every row, and low ≤ a ≤ high.

    After a fixed number of sweeps the action is drawn back by one factor toward a retreat, the one
    nearest to rest that came out likewise, until it keeps every row as well as the retreat does.
    Where no action keeps all rows, the last ones are kept best, since a sweep ends with them.
    Where rest keeps all rows (b ≤ 0) it is the retreat, so that the action is safe where the sweeps
    have not converged; where something comes nearer, the retreat gets out of its way.

    Args:
        wish: w, ``(*B, n)``.
        within: The bounds.
        sweeps: How many.
        inverse: M⁻¹, ``(*B, n, n)``, symmetric and positive definite; None for M = I.

    Returns:
        The action and the force of the bounds.
    """
    normals, bounds = _normalised(within)
    if inverse is None:
        action, force = _projected(wish, normals, bounds, within, sweeps)
    else:
        action, force = _projected_in(inverse, wish, normals, bounds, within, sweeps)
    retreat, _ = _projected(torch.zeros_like(wish), normals, bounds, within, sweeps)
    return SafeAction(_drawn_back(action, retreat, normals, bounds, within), force)


def _projected(
    wish: Tensor, normals: Tensor, bounds: Tensor, within: SafetyBounds, sweeps: int
) -> SafeAction:
    """The nearest action, as far as the sweeps converge.

    Hildreth's method (1957): one row after the other is satisfied by the least change, and what an
    earlier sweep changed too much is taken back; the box is one more set to project on.
    """
    normal_of, bound_of = normals.unbind(-2), bounds.unbind(-1)
    action = wish
    beyond = torch.zeros_like(wish)  # what the box took away
    multipliers = [torch.zeros_like(bound) for bound in bound_of]

    for _ in range(sweeps):
        # Each row: the least multiplier ≥ 0 that satisfies it.
        for index, (normal, bound) in enumerate(zip(normal_of, bound_of, strict=True)):
            missing = bound - (normal * action).sum(-1)
            multiplier = (multipliers[index] + missing).clamp(min=0.0)
            change = multiplier - multipliers[index]
            action = action + change.unsqueeze(-1) * normal
            multipliers[index] = multiplier

        # The box: the nearest action within.
        unbounded = action + beyond
        action = torch.minimum(torch.maximum(unbounded, within.low), within.high)
        beyond = unbounded - action

    force = -beyond
    for normal, multiplier in zip(normal_of, multipliers, strict=True):
        force = force + multiplier.unsqueeze(-1) * normal
    return SafeAction(action, force)


def _projected_in(
    inverse: Tensor,
    wish: Tensor,
    normals: Tensor,
    bounds: Tensor,
    within: SafetyBounds,
    sweeps: int,
) -> SafeAction:
    """The nearest action in a metric M, likewise: the least change for a row c is along M⁻¹c.

    In a metric a bound on one component moves the others as well, so that each side of the box is
    a row of its own.
    """
    changes = normals @ inverse  # the rows (M⁻¹c)ᵀ, since M is symmetric
    effects = (changes * normals).sum(-1)  # cᵀM⁻¹c, by how much each changes its own row
    effects = torch.where(effects > 0.0, effects, 1.0)
    rows = [values.unbind(-2) for values in (normals, changes)]
    numbers = [values.unbind(-1) for values in (bounds, effects)]

    sides = [values.unbind(-1) for values in (within.low, within.high, inverse.diagonal(0, -2, -1))]
    columns = inverse.unbind(-1)
    multipliers = [torch.zeros_like(bound) for bound in numbers[0]]
    pushes = [torch.zeros_like(side) for side in sides[0]]

    action = wish
    for _ in range(sweeps):
        # Each row: the least multiplier ≥ 0 that satisfies it.
        for index, (normal, along, bound, effect) in enumerate(zip(*rows, *numbers, strict=True)):
            missing = bound - (normal * action).sum(-1)
            multiplier = (multipliers[index] + missing / effect).clamp(min=0.0)
            change = multiplier - multipliers[index]
            action = action + change.unsqueeze(-1) * along
            multipliers[index] = multiplier

        # Each component: the least push that brings it within the box.
        for index, (low, high, effect) in enumerate(zip(*sides, strict=True)):
            free = action[..., index] - pushes[index] * effect
            push = (torch.minimum(torch.maximum(free, low), high) - free) / effect
            action = action + (push - pushes[index]).unsqueeze(-1) * columns[index]
            pushes[index] = push

    force = torch.stack(pushes, dim=-1)
    for normal, multiplier in zip(rows[0], multipliers, strict=True):
        force = force + multiplier.unsqueeze(-1) * normal
    return SafeAction(torch.minimum(torch.maximum(action, within.low), within.high), force)


def _normalised(within: SafetyBounds) -> tuple[Tensor, Tensor]:
    """Rows of length one; those that no action changes ask for nothing."""
    lengths = torch.linalg.vector_norm(within.slopes, dim=-1)
    matters = lengths > torch.finfo(lengths.dtype).eps

    divisor = torch.where(matters, lengths, 1.0)
    normals = torch.where(matters.unsqueeze(-1), within.slopes / divisor.unsqueeze(-1), 0.0)
    bounds = torch.where(matters, within.bounds / divisor, -1.0)
    return normals, bounds


def _drawn_back(
    action: Tensor, retreat: Tensor, normals: Tensor, bounds: Tensor, within: SafetyBounds
) -> Tensor:
    """The action nearest to the wish, on the way to it from the retreat, that keeps every row."""
    if normals.shape[-2] == 0:
        return action
    slack = SLACK * (within.high - within.low).amax(-1, keepdim=True)
    closing = -(normals * (action - retreat).unsqueeze(-2)).sum(-1)
    kept = (normals * retreat.unsqueeze(-2)).sum(-1) - bounds
    room = slack + kept.clamp(min=0.0)  # how much faster than in the retreat each gap may close

    exceeds = closing > room
    share = torch.where(exceeds, room / torch.where(exceeds, closing, 1.0), 1.0)
    drawn_back: Tensor = retreat + (action - retreat) * share.amin(-1, keepdim=True)
    return drawn_back
