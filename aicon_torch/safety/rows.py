"""Linear bounds on an action, as rows."""

from collections.abc import Sequence
from typing import NamedTuple

import torch
from torch import Tensor


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


class Rows(NamedTuple):
    """Rows n·a ≥ b, most of them of length one.

    Attributes:
        normals: n, ``(*B, m, n)``.
        bounds: b, ``(*B, m)``, in the action's unit where n has length one.
    """

    normals: Tensor
    bounds: Tensor


def joined(rows: Sequence[Rows]) -> Rows:
    """All rows, one after the other."""
    normals = torch.cat([some.normals for some in rows], dim=-2)
    return Rows(normals, torch.cat([some.bounds for some in rows], dim=-1))


def normalised(within: SafetyBounds) -> tuple[Rows, Tensor]:
    """Rows of length one, and what they were divided by, ``(*B, m)``.

    Those that no action changes ask for nothing.
    """
    lengths = torch.linalg.vector_norm(within.slopes, dim=-1)
    matters = lengths > torch.finfo(lengths.dtype).eps

    divisor = torch.where(matters, lengths, 1.0)
    normals = torch.where(matters.unsqueeze(-1), within.slopes / divisor.unsqueeze(-1), 0.0)
    bounds = torch.where(matters, within.bounds / divisor, -1.0)
    return Rows(normals, bounds), divisor


def clamped(action: Tensor, within: SafetyBounds) -> Tensor:
    """The nearest action in the box where all components count alike."""
    return torch.minimum(torch.maximum(action, within.low), within.high)
