"""Geometry of the plane: vectors (x, y), angles, and poses (x, y, θ) of something rigid."""

import torch
from torch import Tensor

from aicon_torch.vectors import wrap_angle


def norm(vectors: Tensor) -> Tensor:
    """√(‖v‖² + ε²): the Euclidean norm ``(*B,)`` of vectors ``(*B, d)``, with a derivative at zero.

    The unit is that of the vectors; ε = 10⁻¹² is lost to rounding anywhere but at zero.
    """
    return torch.sqrt((vectors * vectors).sum(-1) + 1e-24)


def as_points(numbers: Tensor) -> Tensor:
    """x₁, y₁, x₂, y₂ and so on, ``(*B, 2 K)``, as points ``(*B, K, 2)``."""
    return numbers.reshape(*numbers.shape[:-1], -1, 2)


def cross(first: Tensor, second: Tensor) -> Tensor:
    """The planar cross product x₁y₂ − y₁x₂, ``(*B,)``, of vectors ``(*B, 2)``."""
    x_first, y_first = first.unbind(-1)
    x_second, y_second = second.unbind(-1)
    return x_first * y_second - y_first * x_second


def quarter_turn(vectors: Tensor) -> Tensor:
    """(−y, x): vectors ``(*B, 2)`` turned counterclockwise (x towards y) by a right angle."""
    x, y = vectors.unbind(-1)
    return torch.stack((-y, x), dim=-1)


def rotate(vectors: Tensor, angle: Tensor) -> Tensor:
    """R(θ) v: vectors turned counterclockwise (x towards y).

    Args:
        vectors: ``(*B, 2)``.
        angle: θ, ``(*B,)``, rad; it broadcasts with the leading dimensions of the vectors.

    Returns:
        ``(*B, 2)``.
    """
    cos, sin = torch.cos(angle), torch.sin(angle)
    x, y = vectors.unbind(-1)
    return torch.stack((cos * x - sin * y, sin * x + cos * y), dim=-1)


def pose_error(pose: Tensor, target: Tensor, rotation_length: float = 1.0) -> Tensor:
    """(Δx, Δy, L Δθ): from a target to a pose, the rotation as a length and the shorter way round.

    Args:
        pose: (x, y, θ), ``(*B, 3)``, m and rad.
        target: Likewise.
        rotation_length: L, m: a rotation by one rad counts as much as a translation by L.

    Returns:
        ``(*B, 3)``, m; with L = 1 also m and rad, the angle in [−π, π).
    """
    error = pose - target
    angle = wrap_angle(error[..., 2:])
    return torch.cat((error[..., :2], rotation_length * angle), dim=-1)
