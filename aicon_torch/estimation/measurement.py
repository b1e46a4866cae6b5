"""Implicit measurements: what relates an estimate to a reading."""

from collections.abc import Callable, Iterable, Mapping
from typing import NamedTuple

from torch import Tensor, nn

from aicon_torch.errors import GraphError, choices, in_order
from aicon_torch.estimation.covariance import Covariance, Noise
from aicon_torch.interconnections import Interconnection, Values
from aicon_torch.quantities import PRESENT, as_number, as_size


class Innovation(NamedTuple):
    """What a measurement corrects an estimate by, before it does.

    Attributes:
        inputs: Names of what the measurement reads.
        residual: ν = h(x⁻, z), ``(*B, m)``.
        spread: S = H P⁻ Hᵀ + R, ``(*B, m, m)``.
        accepted: Which rows believe the reading, ``(*B,)``; None where all must.
        present: Which rows have one, believed or not, ``(*B,)``; None where all must.
        gate: Squared distance beyond which one that is there is not believed.
    """

    inputs: tuple[str, ...]
    residual: Tensor
    spread: Tensor
    accepted: Tensor | None
    present: Tensor | None = None
    gate: float | None = None


class Measurement(nn.Module):
    """A residual of an estimate and a reading that is zero when the two agree.

    Args:
        function: Residual ``(*B, m)`` of the estimate and of whatever else it names (readings,
            other estimates).
        noise: Variance of the residual: a number, one a component, or a function of quantities; for
            a reading that comes late, a function of its age.
        uncertain: Estimates of *other* estimators that the residual reads, each with the name of
            its covariance, whose uncertainty adds to the noise: ``{"x_hand": "P_hand"}``.
        gate: Largest squared Mahalanobis distance νᵀS⁻¹ν of a reading that is believed; None
            believes all. One that was refused still shapes the gradient of the covariance, as if
            the next one were believed.
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
        size: int = 1,
    ) -> None:
        super().__init__()
        self.residual = Interconnection.of(function, "Measurement")
        self.size = as_size("Measurement", size)
        self.noise = Covariance(noise, self.size)
        self.uncertain = dict(uncertain or {})
        self.gate = None if gate is None else as_number(gate)
        if self.gate is not None and not self.gate > 0:
            raise GraphError(f"Measurement gate={gate!r}: expected a number > 0, or None.")

        # What the residual does not read cannot add to its noise.
        for name in self.uncertain:
            if name not in self.residual.inputs:
                raise GraphError(
                    f"uncertain: the residual reads {choices(self.residual.inputs)}, not {name!r}."
                )

        # Of these, sensors tell in a flag whether they have a reading.
        read = (*self.residual.inputs, *self.noise.inputs, *self.uncertain.values())
        self.inputs = tuple(dict.fromkeys(read))
        self._presence_flags = tuple(name + PRESENT for name in self.inputs)

    def present(self, values: Values) -> Tensor | None:
        """Which rows of the batch have what it reads, ``(*B,)``; None if all must."""
        present = None
        for flag in self._presence_flags:
            if flag in values:
                present = values[flag] if present is None else present & values[flag]
        return present

    def accepted(self, values: Values, squared_distance: Callable[[], Tensor]) -> Tensor | None:
        """Which rows of the batch believe the reading, ``(*B,)``; None if all must.

        Args:
            values: Named values of the step, with every sensor's presence, ``name.present``.
            squared_distance: Gives the squared Mahalanobis distance ``(*B,)`` of the residual.
        """
        present = self.present(values)
        if self.gate is None:
            return present
        within = squared_distance() <= self.gate
        return within if present is None else within & present

    def innovation(
        self, values: Values, name: str, differentiable: bool = False
    ) -> tuple[Tensor, Tensor, Tensor]:
        """Residual, its Jacobian by the estimate ``name``, and the covariance of its noise.

        Returns:
            ν ``(*B, m)``, H ``(*B, m, n)`` and R ``(*B, m, m)``.
        """
        residual, jacobian = self.residual.linearize(values, name, self.size, differentiable)
        return residual, jacobian, self.uncertainty(values, differentiable)

    def uncertainty(self, values: Values, differentiable: bool = False) -> Tensor:
        """R ``(*B, m, m)``: the covariance of the noise, and what other estimates add to it."""
        # R + Σ G P Gᵀ, with the derivative G of the residual by each of the other estimates.
        noise: Tensor = self.noise(values)
        for other, covariance in self.uncertain.items():
            _, sensitivity = self.residual.linearize(values, other, self.size, differentiable)
            noise = noise + sensitivity @ values[covariance] @ sensitivity.mT
        return noise


def in_turn(named: str, given: Iterable[Measurement]) -> tuple[Measurement, ...]:
    """The measurements of a filter, in the order in which they correct it.

    Args:
        named: What an error calls them.
        given: The measurements.

    Raises:
        GraphError: If one is something else.
    """
    measurements = in_order(named, given)
    for measurement in measurements:
        if not isinstance(measurement, Measurement):
            raise GraphError(
                f"{named}: expected Measurement(residual, noise=...), got in it {measurement!r}."
            )
    return measurements
