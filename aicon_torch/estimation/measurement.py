"""Kalman filtering with implicit measurements: the arithmetic behind the estimators."""

from collections.abc import Callable, Mapping, Sequence
from typing import Literal, NamedTuple, cast

import torch
from torch import Tensor, nn

from aicon_torch.errors import GraphError, choices
from aicon_torch.interconnections import Interconnection, Node, Values

Noise = float | Sequence[float] | Callable[..., Tensor]
"""A variance, a variance per component, or a function of quantities that returns variances ``(*B, n)``."""


class Covariance(Node):
    """The covariance of a noise, constant or a function of quantities wired by its parameter names.

    Args:
        noise: A variance, one variance a component, or a function that returns variances ``(*B, n)``.
        size: Number of components n.
    """

    def __init__(self, noise: Noise, size: int) -> None:
        super().__init__()
        self.relation = Interconnection(noise) if callable(noise) else None
        self.inputs = self.relation.inputs if self.relation else ()
        if not callable(noise):
            variances = torch.as_tensor(noise, dtype=torch.float64)
            if variances.dim() > 1 or (variances.dim() == 1 and len(variances) != size) or not (variances >= 0).all():
                raise GraphError(f"noise={noise!r}: expected one variance >= 0 or {size}, one a component.")
            self.register_buffer("constant", torch.diag(variances.expand(size).clone()))

    def forward(self, values: Values) -> Tensor:
        """The covariance ``(n, n)`` or ``(*B, n, n)``."""
        if self.relation is None:
            return cast(Tensor, self.constant)
        return torch.diag_embed(self.relation(values))


class Measurement(nn.Module):
    """An implicit measurement: a residual of an estimate and a reading that is zero when the two agree.

    Args:
        function: Residual ``(*B, m)`` of the estimate and of whatever else it names (readings, other estimates).
        noise: Variance of the residual: a number, one a component, or a function of quantities; for a reading that
            comes late, a function of its age.
        uncertain: Estimates of *other* estimators that the residual reads, each with the name of its covariance,
            whose uncertainty adds to the noise: ``{"x_hand": "P_hand"}``.
        gate: Largest squared Mahalanobis distance νᵀS⁻¹ν of a reading that is believed; None believes all.
        gate_keeps_gradient: Whether a reading that was refused still shapes the gradient of the covariance, as if the
            next one were believed.
        size: Number m of components of the residual.

    Example:
        >>> def bearing(p_tar, z_tar):  # rad
        ...     return wrap(angle(p_tar) - z_tar)
        >>> Measurement(bearing, noise=0.03**2, gate=9.0)
    """

    def __init__(
        self,
        function: Callable[..., Tensor] | Interconnection,
        noise: Noise,
        *,
        uncertain: Mapping[str, str] | None = None,
        gate: float | None = None,
        gate_keeps_gradient: bool = True,
        size: int = 1,
    ) -> None:
        super().__init__()
        self.residual = Interconnection.of(function)
        self.noise = Covariance(noise, size)
        self.uncertain = dict(uncertain or {})
        for name in self.uncertain:
            if name not in self.residual.inputs:
                raise GraphError(f"uncertain: the residual reads {choices(self.residual.inputs)}, not {name!r}.")
        self.gate = gate
        self.gate_keeps_gradient = gate_keeps_gradient
        self.size = size
        self.inputs = tuple(dict.fromkeys((*self.residual.inputs, *self.noise.inputs, *self.uncertain.values())))
        self.optional: tuple[str, ...] = ()  # the presence flags of optional sensors it reads, named by the world model

    def accepted(self, values: Values, distance: Callable[[], Tensor]) -> Tensor | None:
        """Which rows of the batch believe the reading, ``(*B,)``; None if all must.

        Args:
            values: Named values of the step, with the presence flags of optional sensors.
            distance: Gives the squared Mahalanobis distance ``(*B,)`` of the residual.
        """
        accepted = distance() <= self.gate if self.gate is not None else None
        for flag in self.optional:
            present = cast(Tensor, values[flag])
            accepted = present if accepted is None else accepted & present
        return accepted

    def innovation(self, values: Values, name: str, differentiable: bool = False) -> tuple[Tensor, Tensor, Tensor]:
        """Residual, its Jacobian by the estimate ``name``, and the covariance of its noise.

        Returns:
            ν ``(*B, m)``, H ``(*B, m, n)`` and R ``(*B, m, m)``.
        """
        residual, jacobian = self.residual.linearize(values, name, self.size, differentiable)
        return residual, jacobian, self.uncertainty(values, differentiable)

    def uncertainty(self, values: Values, differentiable: bool = False) -> Tensor:
        """R ``(*B, m, m)``: the covariance of the noise, and what other estimates add to it."""
        noise: Tensor = self.noise(values)
        for other, covariance in self.uncertain.items():
            _, sensitivity = self.residual.linearize(values, other, self.size, differentiable)
            noise = noise + sensitivity @ cast(Tensor, values[covariance]) @ sensitivity.mT
        return noise


class Correction(NamedTuple):
    """The Kalman correction of a Gaussian by one measurement, x⁺ = x − Kν and P⁺ = P − K S Kᵀ.

    With S = H P Hᵀ + R and K = P Hᵀ S⁻¹; ν = h(x, z) is the implicit residual, hence the minus sign.

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
        """The correction of P ``(*B, n, n)`` by a measurement with H ``(*B, m, n)`` and R ``(*B, m, m)``."""
        if jacobian.shape[-2] == 1:  # products with a row are faster than with a matrix
            cross = (covariance * jacobian).sum(-1).unsqueeze(-2)
            spread = (cross * jacobian).sum(-1, keepdim=True) + noise
            return cls(cross, spread, cross / spread)
        cross = jacobian @ covariance
        spread = cross @ jacobian.mT + noise
        return cls(cross, spread, torch.linalg.solve_ex(spread, cross).result)

    def of_mean(self, residual: Tensor, detach_gain: bool = False) -> Tensor:
        """Kν of a residual ν ``(*B, m)``, ``(*B, n)``, to be subtracted."""
        gain = self.gain.detach() if detach_gain else self.gain  # stops the derivative of the gain by the state
        return (gain * residual.unsqueeze(-1)).sum(-2)

    def of_covariance(self) -> Tensor:
        """K S Kᵀ, ``(*B, n, n)``, symmetric, to be subtracted."""
        single = self.cross.shape[-2] == 1
        reduction: Tensor = self.gain.mT * self.cross if single else self.gain.mT @ self.cross
        return reduction if single else (reduction + reduction.mT) / 2

    def distance(self, residual: Tensor) -> Tensor:
        """Squared Mahalanobis distance νᵀS⁻¹ν of a residual ν ``(*B, m)``, ``(*B,)``."""
        squared: Tensor = residual * torch.linalg.solve_ex(self.spread, residual.unsqueeze(-1)).result.squeeze(-1)
        return squared.sum(-1)


Derivative = Literal["model", "update", "detached_gain"]
