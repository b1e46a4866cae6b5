"""A clearance with its direction, x_obs = (d, ∇d): how far an obstacle is, and how that grows.

The sensor feels d alone. ∇d is estimated from how d changes with the robot's motion.
"""

from dataclasses import dataclass
from typing import cast

import torch
from torch import Tensor

from aicon_torch.interconnections import Affine
from aicon_torch.vectors import unit

DIRECTION_VARIANCE = 0.5
"""Variance of each component of ∇d before the first motion: any direction is possible."""


def slide(x_obs: Tensor, x_rob: Tensor) -> Tensor:
    """(d + ∇d·x_rob, ∇d): the clearance after a displacement, as along a straight wall.

    Args:
        x_obs: (d, ∇d), ``(*B, 3)``, m and m/m.
        x_rob: The displacement, ``(*B, 2)``, m.

    Returns:
        ``(*B, 3)``, m and m/m.
    """
    distance, gradient = x_obs[..., :1], x_obs[..., 1:]
    change = (gradient * x_rob).sum(-1, keepdim=True)
    return torch.cat((distance + change, gradient), dim=-1)


def slide_jacobian(x_rob: Tensor) -> Tensor:
    """∂slide/∂x_obs = (1, x_rob; 0, I), ``(*B, 3, 3)``, of a displacement ``(*B, 2)``, m."""
    by_gradient = torch.nn.functional.pad(x_rob.unsqueeze(-2), (1, 0, 0, 2))
    return torch.eye(3, dtype=x_rob.dtype, device=x_rob.device) + by_gradient


def range_residual() -> Affine:
    """The residual d − z_obs, ``(*B, 1)``, m: zero where the clearance is what the sensor reads."""
    return Affine(x_obs=torch.tensor([[1.0, 0.0, 0.0]]), z_obs=-1.0)


def unit_gradient_residual(x_obs: Tensor) -> Tensor:
    """|∇d| − 1, ``(*B, 1)``, of (d, ∇d) ``(*B, 3)``: a clearance grows by one metre a metre."""
    gradient = x_obs[..., 1:]
    return cast(Tensor, torch.linalg.vector_norm(gradient, dim=-1, keepdim=True) - 1.0)


def unit_gradient_jacobian(x_obs: Tensor) -> Tensor:
    """∂(|∇d| − 1)/∂x_obs = (0, ∇d/|∇d|), ``(*B, 1, 3)``; zero where ∇d is."""
    gradient = x_obs[..., 1:]
    length = torch.linalg.vector_norm(gradient, dim=-1, keepdim=True)
    return torch.nn.functional.pad(gradient / length.clamp(min=1e-9), (1, 0)).unsqueeze(-2)


def direction_residual(x_obs: Tensor, z_dir: Tensor) -> Tensor:
    """∇d + (cos z, sin z): zero where ∇d points away from the nearest obstacle.

    Args:
        x_obs: (d, ∇d), ``(*B, 3)``.
        z_dir: Direction of the nearest obstacle, ``(*B, 1)``, rad.

    Returns:
        ``(*B, 2)``.
    """
    towards = torch.cat((torch.cos(z_dir), torch.sin(z_dir)), dim=-1)
    return x_obs[..., 1:] + towards


@dataclass(frozen=True)
class ClearancePrior:
    """The clearance at first: as it is felt, with no idea of its direction.

    Attributes:
        noise: Standard deviation of a reading, m.
    """

    noise: float

    def __call__(self, z_obs: Tensor) -> tuple[Tensor, Tensor]:
        """Mean ``(*B, 3)`` and covariance ``(3, 3)`` by the first reading ``(*B, 1)``, m."""
        unknown = torch.zeros_like(z_obs)
        variances = (self.noise**2, DIRECTION_VARIANCE, DIRECTION_VARIANCE)
        mean = torch.cat((z_obs, unknown, unknown), dim=-1)
        return mean, torch.diag(z_obs.new_tensor(variances))


@dataclass(frozen=True)
class CollisionLikelihood:
    """g₂ = p_collision = exp(−d/ℓ): its gradient keeps growing toward contact.

    Attributes:
        length: ℓ, m.
    """

    length: float

    def __call__(self, x_obs: Tensor) -> Tensor:
        """The likelihood ``(*B,)`` with a clearance (d, ∇d) ``(*B, 3)``."""
        return torch.exp(-x_obs[..., 0] / self.length)


@dataclass(frozen=True)
class ClearanceLimits:
    """Near an obstacle a velocity is limited by what may have happened since it was felt.

    With the clearance d₋ = d − 2σ_d that is certain enough, ‖a‖ ≤ max(v_min, d₋/τ), and the
    velocity away from the obstacle n·a ≥ (m − d₋)/τ: a damper, which asks for retreat below m.

    Attributes:
        time: τ, s.
        margin: m, m.
        slowest: v_min, m/s: without motion the direction of an obstacle stays unknown.
    """

    time: float
    margin: float
    slowest: float

    @classmethod
    def for_latency(cls, latency: float) -> "ClearanceLimits":
        """Limits for readings that are so late, s; margin and times are from trials."""
        return cls(time=0.2 + latency, margin=0.04, slowest=0.05)

    def __call__(self, a: Tensor, x_obs: Tensor, P_obs: Tensor) -> Tensor:
        """The velocity within the limits.

        Args:
            a: The velocity that is wished for, ``(*B, 2)``, m/s.
            x_obs: (d, ∇d), ``(*B, 3)``, m and m/m.
            P_obs: Its covariance, ``(*B, 3, 3)``.

        Returns:
            ``(*B, 2)``, m/s.
        """
        deviation = P_obs[..., 0, 0].clamp(min=0.0).sqrt()
        certain = (x_obs[..., 0] - 2.0 * deviation).unsqueeze(-1)

        # No faster than what is left allows.
        speed = torch.linalg.vector_norm(a, dim=-1, keepdim=True)
        fastest = (certain / self.time).clamp(min=self.slowest)
        slowed = a * (fastest / torch.maximum(speed, fastest))

        # Away from the obstacle where it is too near.
        away = unit(x_obs[..., 1:])
        retreat = (self.margin - certain) / self.time
        missing = (retreat - (slowed * away).sum(-1, keepdim=True)).clamp(min=0.0)
        return slowed + missing * away
