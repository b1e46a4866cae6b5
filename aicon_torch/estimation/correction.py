"""The Kalman correction of a Gaussian by one measurement."""

from typing import NamedTuple

import torch
from torch import Tensor

from aicon_torch.differentiation import stop

CANCELS = 1e-10
"""Of a type whose numbers differ by a larger share, a difference of covariances is not sure."""


class Correction(NamedTuple):
    """x⁺ = x − Kν and P⁺ = P − K S Kᵀ, with S = H P Hᵀ + R and K = P Hᵀ S⁻¹.

    ν = h(x, z) is the residual of an implicit measurement, hence the minus sign.

    Attributes:
        cross: H P, ``(*B, m, n)``.
        spread: S, ``(*B, m, m)``.
        gain: Kᵀ, ``(*B, m, n)``.
    """

    cross: Tensor
    spread: Tensor
    gain: Tensor

    @classmethod
    def by(cls, covariance: Tensor, jacobian: Tensor, noise: Tensor) -> "Correction":
        """The correction of P ``(*B, n, n)`` by H ``(*B, m, n)`` and R ``(*B, m, m)``."""
        # With one component S is a number, and products with a row are faster than with a matrix.
        if jacobian.shape[-2] == 1:
            cross = (covariance * jacobian).sum(-1).unsqueeze(-2)
            spread = (cross * jacobian).sum(-1, keepdim=True) + noise
            return cls(cross, spread, cross / spread)

        cross = jacobian @ covariance
        spread = cross @ jacobian.mT + noise
        return cls(cross, spread, torch.linalg.solve_ex(spread, cross).result)

    def of_mean(self, residual: Tensor, detach_gain: bool = False) -> Tensor:
        """Kν of a residual ν ``(*B, m)``, ``(*B, n)``, to be subtracted."""
        gain = self.gain
        if detach_gain:
            gain = stop(gain)  # stops the derivative of the gain by the state
        return (gain * residual.unsqueeze(-1)).sum(-2)

    def of_covariance(self) -> Tensor:
        """K S Kᵀ, ``(*B, n, n)``, symmetric, to be subtracted."""
        if self.cross.shape[-2] == 1:
            outer: Tensor = self.gain.mT * self.cross
            return outer

        reduction: Tensor = self.gain.mT @ self.cross
        return (reduction + reduction.mT) / 2

    def corrected(self, covariance: Tensor, jacobian: Tensor, noise: Tensor) -> Tensor:
        """P⁺, ``(*B, n, n)``, symmetric, of what the correction is :meth:`by`.

        In single precision the difference cancels where a reading is far better than the belief,
        and P⁺ may become negative. There it is Joseph's form, a sum of squares:
        (I − KH) P (I − KH)ᵀ + K R Kᵀ (Bucy and Joseph 1968).
        """
        if torch.finfo(covariance.dtype).eps < CANCELS:
            return covariance - self.of_covariance()

        gain = self.gain.mT
        rest = torch.eye(covariance.shape[-1]).to(covariance) - gain @ jacobian
        corrected: Tensor = rest @ covariance @ rest.mT + gain @ noise @ gain.mT
        return (corrected + corrected.mT) / 2

    def squared_distance(self, residual: Tensor) -> Tensor:
        """Squared Mahalanobis distance νᵀS⁻¹ν of a residual ν ``(*B, m)``, ``(*B,)``."""
        whitened = torch.linalg.solve_ex(self.spread, residual.unsqueeze(-1)).result.squeeze(-1)
        squared: Tensor = (residual * whitened).sum(-1)
        return squared
