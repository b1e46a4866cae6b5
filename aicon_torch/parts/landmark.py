"""A landmark of which a robot sees the bearing: p_tar, its position relative to the robot.

The axes are those of the world; only the origin moves with the robot.
"""

from dataclasses import dataclass
from typing import cast

import torch
from torch import Tensor

from aicon_torch.interconnections import Affine
from aicon_torch.parts.planar import quarter_turn, wrap_angle

NEAREST = 1e-4
"""Squared distance below which a bearing's derivative grows no more, m²: 1 cm."""


def approach() -> Affine:
    """p_tar − x_rob: the landmark comes nearer by what the robot moves, ``(*B, 2)``, m."""
    return Affine(p_tar=1.0, x_rob=-1.0)


def bearing_residual(p_tar: Tensor, z_tar: Tensor) -> Tensor:
    """atan2(y, x) − z: zero where a landmark lies in the direction in which it is seen.

    Args:
        p_tar: Its position (x, y), ``(*B, 2)``, m.
        z_tar: The bearing, ``(*B, 1)``, rad.

    Returns:
        ``(*B, 1)``, rad in [−π, π).
    """
    return wrap_angle(torch.atan2(p_tar[..., 1:], p_tar[..., :1]) - z_tar)


def bearing_jacobian(p_tar: Tensor) -> Tensor:
    """∂bearing/∂p = (−y, x)/‖p‖², ``(*B, 1, 2)``, rad/m; nearer than 1 cm as at 1 cm."""
    squared_distance = (p_tar * p_tar).sum(-1, keepdim=True).clamp(min=NEAREST)
    return (quarter_turn(p_tar) / squared_distance).unsqueeze(-2)


@dataclass(frozen=True)
class BearingPrior:
    """Where a landmark is believed at first: at some distance along the first bearing.

    Attributes:
        distance: Believed distance, m.
        across: Standard deviation across the line of sight, m.
        along: Standard deviation along the line of sight, m.
    """

    distance: float
    across: float
    along: float

    def __call__(self, z_tar: Tensor) -> tuple[Tensor, Tensor]:
        """Mean ``(*B, 2)``, m, and covariance ``(*B, 2, 2)``, m², by a bearing ``(*B, 1)``, rad."""
        sight = torch.cat((torch.cos(z_tar), torch.sin(z_tar)), dim=-1)
        identity = torch.eye(2, dtype=z_tar.dtype, device=z_tar.device)

        variance_gap = self.along**2 - self.across**2
        elongation = variance_gap * sight.unsqueeze(-1) * sight.unsqueeze(-2)
        return self.distance * sight, elongation + self.across**2 * identity


def expected_distance(p_tar: Tensor, P_tar: Tensor) -> Tensor:
    """g₁ = ‖μ_tar‖ + tr Σ_tar: how far a landmark is, and how uncertain.

    Args:
        p_tar: μ, ``(*B, 2)``, m.
        P_tar: Σ, ``(*B, 2, 2)``, m².

    Returns:
        ``(*B,)``; the text adds the two as they are, 1 m² counting as 1 m.
    """
    distance = torch.linalg.vector_norm(p_tar, dim=-1)
    uncertainty = P_tar.diagonal(dim1=-2, dim2=-1).sum(-1)
    return cast(Tensor, distance + uncertainty)
