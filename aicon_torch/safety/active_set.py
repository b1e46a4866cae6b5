"""The nearest action that keeps linear bounds, exactly: a dual active-set method."""

from typing import Any, NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from aicon_torch.differentiation import learns
from aicon_torch.errors import OptionError
from aicon_torch.safety.rows import Rows, SafetyBounds

MISSED = 1e-5
"""By how much a row of length one is missed at least, as a share of its bound and of the largest
component that the action has had: less is left to rounding."""

DEPENDENT = 1e-12
"""A row depends on the active ones if they leave no more of its square than this share."""

FALLS = 1e-10
"""A multiplier that falls more slowly than this never comes to zero."""

MOST = 200
"""Rows that are taken up at most. In exact arithmetic the method ends by itself."""

Array = NDArray[np.float64]


def exactly_within(
    nominal: Tensor, rows: Rows, within: SafetyBounds, inverse: Tensor
) -> tuple[Tensor, Tensor]:
    """The action that keeps rows and box, and the force of the bounds, ``(*B, n)`` both.

    Args:
        nominal: w.
        rows: The rows.
        within: The bounds, with the box.
        inverse: M⁻¹, ``(*B, n, n)``.

    Raises:
        OptionError: If something is to be learned through it, since it is no function of torch.
    """
    if learns():
        raise OptionError(
            "dampers.sweeps=None: gradients do not go through the exact solver. To learn through "
            "time, give a number of sweeps, such as 12."
        )

    # The sides of the box are rows as well.
    identity = torch.eye(nominal.shape[-1], dtype=nominal.dtype, device=nominal.device)
    sides = torch.cat((identity, -identity)).expand(*rows.normals.shape[:-2], -1, -1)
    limits = torch.cat((within.low, -within.high), dim=-1).expand(*rows.bounds.shape[:-1], -1)
    normals = torch.cat((rows.normals, sides), dim=-2)
    found = exactly(nominal, normals, torch.cat((rows.bounds, limits), dim=-1), inverse)
    action, force = found.chunk(2, dim=-1)
    return action, force


@torch.library.custom_op("aicon::exactly", mutates_args=())
def exactly(nominal: Tensor, normals: Tensor, bounds: Tensor, inverse: Tensor) -> Tensor:
    """The action a = argmin (a − w)ᵀM(a − w) with n·a ≥ b for every row.

    The dual method of Goldfarb and Idnani (1983). From a = w, the row that is missed most is
    satisfied by the least change that leaves those at their bounds there, and joins them; where
    that would need a multiplier below 0, its row is let go first. The cost rises with every row, so
    none of the sets of rows comes twice. Where no action keeps all rows, it is w, as
    where M⁻¹ is not positive definite. A row whose bound is no number (NaN) bounds nothing.

    Args:
        nominal: w, ``(*B, n)``.
        normals: n, ``(*B, m, n)``.
        bounds: b, ``(*B, m)``.
        inverse: M⁻¹, ``(*B, n, n)``.

    Returns:
        The action and the force of the bounds, f = Σ μᵢnᵢ, one after the other, ``(*B, 2 n)``.
    """
    batch, size = nominal.shape[:-1], nominal.shape[-1]

    def of_each(tensor: Tensor, dimensions: int) -> Array:
        expanded = tensor.expand(*batch, *tensor.shape[-dimensions:])
        array: Array = expanded.cpu().double().numpy()
        return array

    w, n, b = of_each(nominal, 1), of_each(normals, 2), of_each(bounds, 1)
    metric = of_each(inverse, 2)
    found = np.empty((*batch, 2 * size))
    for place in np.ndindex(*batch):
        found[place] = _nearest(w[place], n[place], b[place], metric[place])
    return torch.from_numpy(found).to(nominal)


@exactly.register_fake
def _(nominal: Tensor, *_: Any) -> Tensor:
    return nominal.new_empty((*nominal.shape[:-1], 2 * nominal.shape[-1]))


def _nearest(nominal: Array, normals: Array, bounds: Array, inverse: Array) -> Array:
    """The same for one robot."""
    root = _root(inverse)
    if root is None:
        return np.concatenate((nominal, np.zeros_like(nominal)))

    turned = normals @ root  # M⁻¹ = K Kᵀ: along Kᵀn, all components count alike
    action, active, largest = nominal.copy(), _Active([], np.empty(0)), 0.0

    for _ in range(MOST):
        largest = max(largest, np.abs(action).max())
        missing = bounds - normals @ action
        is_missed = missing > MISSED * (np.abs(bounds) + largest)
        if not is_missed.any():
            return np.concatenate((action, active.multipliers @ normals[active.rows]))

        row = int(np.argmax(np.where(is_missed, missing, 0.0)))
        following = _with_row(row, float(missing[row]), active, turned)
        if following is None:
            break
        change, active = following
        action = action + root @ change
    return np.concatenate((nominal, np.zeros_like(nominal)))


def _root(inverse: Array) -> Array | None:
    """K of M⁻¹ = K Kᵀ; None where M⁻¹ is no number or not positive definite."""
    if not np.isfinite(inverse).all():
        return None
    try:
        return np.asarray(np.linalg.cholesky(inverse), np.float64)
    except np.linalg.LinAlgError:
        return None


class _Active(NamedTuple):
    """The rows at their bounds.

    Attributes:
        rows: Which.
        multipliers: μ ≥ 0 of each.
    """

    rows: list[int]
    multipliers: Array


def _with_row(
    row: int, missing: float, active: _Active, turned: Array
) -> tuple[Array, _Active] | None:
    """How the action changes with one more active row; None where it cannot be kept besides them.

    Args:
        row: Which row.
        missing: By how much it is missed.
        active: The active rows.
        turned: Kᵀn, ``(m, n)``.

    Returns:
        K⁻¹ times the change ``(n,)``, and the rows that are active now.
    """
    (rows, multipliers), own, change = active, 0.0, np.zeros(turned.shape[-1])
    whole = turned[row]
    while True:
        # Along its own direction the active rows would leave their bounds: what stands apart from
        # them does not. A share of each takes the rest back.
        axes, factors = np.linalg.qr(turned[rows].T)
        along = axes.T @ whole
        apart = whole - axes @ along
        again = axes.T @ apart  # once more, against rounding
        apart, along = apart - axes @ again, along + again
        shares = np.linalg.solve(factors, along)
        effect = apart @ apart

        # How far until the row is kept, and how far until a multiplier comes to zero.
        is_free = effect > DEPENDENT * (whole @ whole)
        full = missing / effect if is_free else np.inf
        falling = shares > FALLS
        steps = np.where(falling, multipliers / np.where(falling, shares, 1.0), np.inf)
        step = min(full, steps.min(initial=np.inf))
        if step == np.inf:
            return None

        if is_free:
            change, missing = change + step * apart, missing - step * effect
        multipliers, own = multipliers - step * shares, own + step
        if step == full:
            return change, _Active([*rows, row], np.append(multipliers, own))
        let_go = int(steps.argmin())
        rows, multipliers = rows[:let_go] + rows[let_go + 1 :], np.delete(multipliers, let_go)
