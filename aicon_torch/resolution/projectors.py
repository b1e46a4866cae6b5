"""Projectors into the nullspace of a gradient, in the forms that the paper gives (Eq. 4-6)."""

from collections.abc import Callable

import torch
from torch import Tensor

from aicon_torch.vectors import reject, unit

Projector = Callable[[Tensor, Tensor], Tensor]
"""From a gradient ``(*B, d)`` and others ``(*B, n, d)`` to what is left of the others."""


def orthogonal(top: Tensor, gradients: Tensor) -> Tensor:
    """(I − vvᵀ) ∇ with v = top/‖top‖ (Eq. 6).

    Args:
        top: The gradient of higher priority, ``(*B, d)``.
        gradients: Those to project, ``(*B, n, d)``.
    """
    return reject(gradients, unit(top).unsqueeze(-2))


def qr(top: Tensor, gradients: Tensor) -> Tensor:
    """(I − QQᵀ) ∇ with Jᵀ = QR (Eq. 5), J the row ``top``.

    A gradient that is zero takes nothing away.
    """
    q = torch.linalg.qr(top.unsqueeze(-1)).Q

    # QR of a zero gives some unit vector all the same.
    q = q * (top != 0).any(-1)[..., None, None]

    projected: Tensor = gradients - (gradients @ q) @ q.mT
    return projected


def pinv(top: Tensor, gradients: Tensor) -> Tensor:
    """(I − J⁺J) ∇ (Eq. 4); a gradient that is not finite takes nothing away."""
    jacobian = top.unsqueeze(-2).nan_to_num(nan=0.0, posinf=0.0, neginf=0.0)

    projected: Tensor = gradients - (gradients @ torch.linalg.pinv(jacobian)) @ jacobian
    return projected


def keep(top: Tensor, gradients: Tensor) -> Tensor:
    """∇ as it is: without projection the result is a weighted sum."""
    return gradients


PROJECTORS: dict[str, Projector] = {
    "orthogonal": orthogonal,
    "qr": qr,
    "pinv": pinv,
    "none": keep,
}
"""The projectors by the names that :class:`~aicon_torch.NullspaceProjection` takes."""
