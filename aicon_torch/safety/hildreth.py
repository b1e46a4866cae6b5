"""The nearest action that keeps linear bounds, as far as sweeps over them converge.

Hildreth's method (1957): one row after the other is satisfied by the least change, and what an
earlier sweep changed too much is taken back. The least change for a row n is along M⁻¹n, and brings
n·a forward by nᵀM⁻¹n.
"""

from collections.abc import Sequence
from typing import Any

import torch
from torch import Tensor

from aicon_torch.safety.rows import Rows, SafetyBounds, clamped


def sweep(
    nominal: Tensor,
    rows: Rows,
    within: SafetyBounds,
    sweeps: int,
    inverse: Tensor | None,
    until_still: bool = False,
) -> tuple[Tensor, Tensor]:
    """The action and the force of the bounds after some sweeps, ``(*B, n)`` both.

    Args:
        nominal: w.
        rows: The rows.
        within: The bounds, with the box.
        sweeps: How many.
        inverse: M⁻¹; None for M = I.
        until_still: Whether to stop where a sweep has changed nothing.
    """
    normal_of, bound_of = rows.normals.unbind(-2), rows.bounds.unbind(-1)
    change_of: Sequence[Tensor] = normal_of
    effect_of: Sequence[float | Tensor] = (1.0,) * len(normal_of)
    if inverse is not None:
        change_of = (rows.normals @ inverse).unbind(-2)
        effect_of = _effects_of(rows, inverse).unbind(-1)

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


def _effects_of(rows: Rows, inverse: Tensor) -> Tensor:
    """By how much a change along M⁻¹n brings n·a forward, nᵀM⁻¹n, ``(*B, m)``; 1 for a row of 0."""
    effects = (rows.normals @ inverse * rows.normals).sum(-1)
    return effects.where(effects > 0.0, 1.0)


def swept_within(
    nominal: Tensor, rows: Rows, within: SafetyBounds, sweeps: int, inverse: Tensor
) -> tuple[Tensor, Tensor]:
    """The same as one operation, which ends where a sweep changes nothing."""
    of_rows = (rows.normals, rows.bounds, _effects_of(rows, inverse))
    found = swept(nominal, *of_rows, within.low, within.high, inverse, sweeps)
    action, force = found.chunk(2, dim=-1)
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
    rows = Rows(normals, bounds)
    found = sweep(nominal, rows, within, sweeps, inverse, until_still=True)
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
        kept = clamped(free, within)
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
