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
        force: f = Σ μᵢcᵢ, what the bounds' multipliers add to the wish, ``(*B, n)``.
    """

    action: Tensor
    force: Tensor


def nearest_safe(wish: Tensor, within: SafetyBounds, sweeps: int) -> SafeAction:
    """The action a = argmin ‖a − w‖² with c·a ≥ b for every row, and low ≤ a ≤ high.

    Hildreth's method (1957): one row after the other is satisfied by the least change, and what an
    earlier sweep changed too much is taken back; the box is one more set to project on. After a
    fixed number of sweeps the action is shortened by one factor until all rows hold that rest would
    keep (b ≤ 0), so that it is safe where the sweeps have not converged.

    Args:
        wish: w, ``(*B, n)``.
        within: The bounds.
        sweeps: How many.

    Returns:
        The action and the force of the bounds.
    """
    normals, bounds = _normalised(within)
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
    return SafeAction(_shortened(action, normals, bounds, within), force)


def _normalised(within: SafetyBounds) -> tuple[Tensor, Tensor]:
    """Rows of length one; those that no action changes ask for nothing."""
    lengths = torch.linalg.vector_norm(within.slopes, dim=-1)
    matters = lengths > torch.finfo(lengths.dtype).eps

    divisor = torch.where(matters, lengths, 1.0)
    normals = torch.where(matters.unsqueeze(-1), within.slopes / divisor.unsqueeze(-1), 0.0)
    bounds = torch.where(matters, within.bounds / divisor, -1.0)
    return normals, bounds


def _shortened(action: Tensor, normals: Tensor, bounds: Tensor, within: SafetyBounds) -> Tensor:
    """The action times the largest factor ≤ 1 with which it keeps all rows that rest keeps."""
    if normals.shape[-2] == 0:
        return action
    slack = SLACK * (within.high - within.low).amax(-1, keepdim=True)
    closing = -(normals * action.unsqueeze(-2)).sum(-1)
    room = slack - bounds  # how fast each gap may close

    exceeds = (bounds <= 0) & (closing > room)
    share = torch.where(exceeds, room / torch.where(exceeds, closing, 1.0), 1.0)
    shortened: Tensor = action * share.amin(-1, keepdim=True)
    return shortened
