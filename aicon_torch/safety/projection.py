"""The action nearest to a wish that keeps linear bounds: a quadratic programme in fixed sweeps."""

from typing import NamedTuple

import torch
from torch import Tensor

SLACK = 1e-4
"""Share of the limit by which a bound may be missed: rounding must not bring a robot to rest."""


class GapRows(NamedTuple):
    """Bounds c·a ≥ b on an action: how fast each gap may close.

    Attributes:
        slopes: c, by how much each gap grows a second and per unit of the action, ``(*B, m, n)``.
        bounds: b, ``(*B, m)``, in the gaps' unit a second. At most 0 where rest is safe.
    """

    slopes: Tensor
    bounds: Tensor


class SafeAction(NamedTuple):
    """What came out.

    Attributes:
        action: a, ``(*B, n)``.
        force: f = Σ μᵢcᵢ, what the bounds' multipliers add to the wish, ``(*B, n)``.
    """

    action: Tensor
    force: Tensor


def nearest_safe(wish: Tensor, rows: GapRows, limits: Tensor, sweeps: int) -> SafeAction:
    """a = argmin ‖a − w‖² subject to c·a ≥ b for every row, and |aⱼ| ≤ limitⱼ.

    Hildreth's method (1957): one row after the other is satisfied by the least change, and what an
    earlier sweep changed too much is taken back; the limits are one more set to project on. After a
    fixed number of sweeps the action is shortened by one factor until all rows hold that rest would
    keep (b ≤ 0), so that it is safe where the sweeps have not converged.

    Args:
        wish: w, ``(*B, n)``.
        rows: The rows.
        limits: The largest of each component, ``(n,)`` or ``(*B, n)``, in the action's unit.
        sweeps: How many.

    Returns:
        The action and the force of the constraints.
    """
    normals, bounds = _normalised(rows)
    normal_of = normals.unbind(-2)
    bound_of = bounds.unbind(-1)

    action = wish
    beyond = torch.zeros_like(wish)  # what the limits took away
    multipliers = [torch.zeros_like(bound) for bound in bound_of]

    for _ in range(sweeps):
        # Each row: the least multiplier ≥ 0 that satisfies it.
        for index, (normal, bound) in enumerate(zip(normal_of, bound_of, strict=True)):
            missing = bound - (normal * action).sum(-1)
            multiplier = (multipliers[index] + missing).clamp(min=0.0)
            change = multiplier - multipliers[index]
            action = action + change.unsqueeze(-1) * normal
            multipliers[index] = multiplier

        # The limits: the nearest action within.
        unlimited = action + beyond
        action = torch.minimum(torch.maximum(unlimited, -limits), limits)
        beyond = unlimited - action

    force = torch.zeros_like(wish)
    for normal, multiplier in zip(normal_of, multipliers, strict=True):
        force = force + multiplier.unsqueeze(-1) * normal
    return SafeAction(_shortened(action, normals, bounds, limits), force)


def _normalised(rows: GapRows) -> tuple[Tensor, Tensor]:
    """Rows of length one; those that no action changes ask for nothing."""
    lengths = torch.linalg.vector_norm(rows.slopes, dim=-1)
    smallest = torch.finfo(lengths.dtype).eps
    matters = lengths > smallest

    divisor = torch.where(matters, lengths, 1.0)
    normals = torch.where(matters.unsqueeze(-1), rows.slopes / divisor.unsqueeze(-1), 0.0)
    bounds = torch.where(matters, rows.bounds / divisor, -1.0)
    return normals, bounds


def _shortened(action: Tensor, normals: Tensor, bounds: Tensor, limits: Tensor) -> Tensor:
    """The action times the largest factor ≤ 1 with which it keeps all rows that rest keeps."""
    slack = SLACK * limits.amin(-1, keepdim=True)
    speeds = (normals * action.unsqueeze(-2)).sum(-1)
    room = (slack - bounds).clamp(min=0.0)  # how fast each gap may close

    exceeds = (bounds <= 0) & (-speeds > room)
    share = torch.where(exceeds, room / torch.where(exceeds, -speeds, 1.0), 1.0)
    shortened: Tensor = action * share.amin(-1, keepdim=True)
    return shortened
