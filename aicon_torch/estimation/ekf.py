"""The extended Kalman filter with implicit measurements."""

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, Literal

import torch
from torch import Tensor, nn

from aicon_torch.differentiation import values_only
from aicon_torch.errors import GraphError, choices
from aicon_torch.estimation.base import Estimator
from aicon_torch.estimation.correction import Correction
from aicon_torch.estimation.covariance import Covariance, Noise
from aicon_torch.estimation.measurement import Innovation, Measurement, in_turn
from aicon_torch.interconnections import Affine, Interconnection, Values
from aicon_torch.quantities import RESTART, as_numbers, as_size
from aicon_torch.validation import check_flag

Derivative = Literal["model", "update", "detached_gain"]
"""Which derivative the anticipated mean has: see :class:`EKF`."""

ConstantPrior = tuple[Sequence[float], float | Sequence[float]]
"""Mean and variances before the first step."""

PriorFunction = Callable[..., tuple[Tensor, Tensor]] | Interconnection
"""A function of the first readings that returns x ``(*B, n)`` and P ``(*B, n, n)``."""


class EKF(Estimator):
    """An extended Kalman filter with implicit measurements: a Gaussian belief N(x, P).

    Predict: x⁻ = f(x, u), P⁻ = F P Fᵀ + Q. Correct, one measurement after the other: with
    ν = h(x⁻, z), S = H P⁻ Hᵀ + R, K = P⁻ Hᵀ S⁻¹: x = x⁻ − Kν, P = P⁻ − K S Kᵀ. F and H are
    derivatives by autograd.

    Args:
        mean: Name of x, ``(*B, n)``.
        covariance: Name of P, ``(*B, n, n)``.
        predict: f, a function that reads ``mean`` and whatever moves it.
        noise: Variances of Q, per step.
        initial: ``(mean, variances)``, or a function of the first readings that returns x ``(*B,
            n)`` and P ``(*B, n, n)``.
        correct: The measurements.
        derivative: Which derivative ``forward`` gives the mean: ``"model"``, that of f, as if the
            correction were noise; ``"update"``, that of the whole next update, readings held;
            ``"detached_gain"``, the same with K held.
        size: Number n of components, needed where ``initial`` is a function.
        is_motion: Whether the mean is itself a motion, such as a velocity that odometry measures.

    Example:
        >>> EKF("p_tar", "P_tar", predict=approach, noise=1e-6, initial=((5.0, 0.0), 9.0),
        ...     correct=[bearing])
    """

    prior_mean: Tensor
    prior_covariance: Tensor

    def __init__(
        self,
        mean: str,
        covariance: str,
        *,
        predict: Callable[..., Tensor] | Interconnection,
        noise: Noise,
        initial: ConstantPrior | PriorFunction,
        correct: Sequence[Measurement] = (),
        derivative: Derivative = "model",
        size: int | None = None,
        is_motion: bool = False,
    ) -> None:
        super().__init__()
        check_flag(f"{mean!r}: is_motion", is_motion)
        self.is_motion = is_motion
        self.mean, self.covariance = mean, covariance
        self.outputs = (mean, covariance)
        self.covariances = (covariance,)
        if derivative not in ("model", "update", "detached_gain"):
            raise GraphError(
                f"derivative={derivative!r}: expected 'model', 'update' or 'detached_gain'."
            )
        self.derivative: Derivative = derivative

        # The belief: how it moves, how it begins, and how uncertain it grows.
        self.predict = Interconnection.of(predict, f"predict of {mean!r}")
        self._must_read_mean(f"predict of {mean!r}", self.predict)
        self.size = self._set_prior(initial, size)
        self.noise = Covariance(noise, self.size)

        # What corrects it.
        self._measurements = in_turn(f"correct of {mean!r}", correct)
        self.measurements = nn.ModuleList(self._measurements)  # registers them
        for measurement in self._measurements:
            self._must_read_mean(f"A measurement of {mean!r}", measurement.residual)

        # All that these read, each named once.
        inputs = [mean, covariance, *self.predict.inputs, *self.noise.inputs, *self.prior_inputs]
        for measurement in self._measurements:
            inputs.extend(measurement.inputs)
        self.inputs = tuple(dict.fromkeys(inputs))

    def initial(self, values: Values) -> dict[str, Tensor]:
        """The prior belief; constants broadcast over the batch."""
        mean, covariance = self._prior_belief(values)
        return {self.mean: mean, self.covariance: covariance}

    @values_only
    def update(self, values: Values) -> dict[str, Tensor]:
        """Predict and correct; readings that are absent or beyond the gate are left out, by row."""
        return self.filtered(values)[0]

    @values_only
    def innovations(self, values: Values) -> list[Innovation]:
        """By how much the readings differ from what was expected: what :meth:`update` corrects by.

        Args:
            values: As for :meth:`update`: the belief before the step, the action and the readings.

        Returns:
            The innovation of each measurement, from the belief that those before it left.
        """
        return self.filtered(values)[1]

    def filtered(self, values: Values) -> tuple[dict[str, Tensor], list[Innovation]]:
        """The belief after prediction and correction, and the innovations."""
        mean, transition = self._predicted_mean(values)
        covariance = self._predicted_covariance(values, transition)
        mean, covariance, innovations = self._corrections(values, mean, covariance)
        return {self.mean: mean, self.covariance: covariance}, innovations

    def forward(self, values: Values, output: str) -> Tensor:
        """The belief one step ahead: the moved mean, or the covariance after measuring there."""
        # The mean as the model alone moves it: the correction to come counts as noise.
        if output == self.mean and self.derivative == "model":
            moved: Tensor = self.predict(values)
            return moved

        # The belief after the next prediction and the next measurements.
        mean, transition = self._predicted_mean(values, differentiable=True)
        covariance = self._predicted_covariance(values, transition)
        for measurement in self._measurements:
            belief = {**values, self.mean: mean, self.covariance: covariance}

            # The model's derivative of the mean takes the correction for noise.
            if self.derivative == "model":
                covariance = self._anticipate_covariance(measurement, belief)
            else:
                mean, covariance = self._anticipate_belief(measurement, belief)

        return mean if output == self.mean else covariance

    def check(self, values: Values) -> None:
        """Compare the Jacobians that the user gave with autograd's.

        Raises:
            GraphError: If one differs.
        """
        self.predict.verify(values, self.size)
        for measurement in self._measurements:
            measurement.residual.verify(values, measurement.size)

    def check_sizes(self, values: Values) -> None:
        """Compare how many components the mean has with those that are predicted and measured.

        Raises:
            GraphError: If they do not fit.
        """
        known = values[self.mean].shape[-1]
        if known != self.size:
            raise GraphError(
                f"initial of {self.mean!r} gives {known} components; expected size={self.size}."
            )

        # It is predicted, and then corrected.
        called = f"predict of {self.mean!r}, which has {self.size} components by initial="
        found = self.predict.components(values, called)
        if found != self.size:
            raise GraphError(
                f"predict of {self.mean!r} gives {found} components; expected {self.size}, as "
                "initial does."
            )
        self._check_residuals("measurement", self._measurements, values)

    def _check_residuals(
        self, kind: str, measurements: Sequence[Measurement], values: Values
    ) -> None:
        """Compare the components of residuals with the sizes that were given."""
        for number, measurement in enumerate(measurements):
            called = f"{kind} {number} of {self.mean!r}"
            found = measurement.residual.components(values, called)
            if found != measurement.size:
                raise GraphError(
                    f"{called} gives {found} components, size={measurement.size}; expected "
                    f"Measurement(..., size={found})."
                )

    def _must_read_mean(self, what: str, relation: Interconnection) -> None:
        if self.mean not in relation.inputs:
            reads = choices(relation.inputs)
            raise GraphError(f"{what} reads {reads}; it must read {self.mean!r}.")

    def _set_prior(self, initial: ConstantPrior | PriorFunction, size: int | None) -> int:
        """Keep the prior, and return the number of components."""
        # A function reads the prior off the first readings ...
        if callable(initial):
            if size is None:
                raise GraphError(
                    f"{self.mean!r}: a function as initial= needs size=, the number of components."
                )
            relation = Interconnection.of(initial, f"initial of {self.mean!r}")
            self.prior: Interconnection | None = relation
            self.prior_inputs = relation.inputs
            return as_size(repr(self.mean), size)

        # ... and numbers are kept with the module, to move between devices with it.
        mean, variances = self._constants(initial)
        covariance = Covariance(variances, len(mean), named="variances of initial")
        self.prior, self.prior_inputs = None, ()
        self.register_buffer("prior_mean", torch.tensor(mean, dtype=torch.float64))
        self.register_buffer("prior_covariance", covariance.constant)
        return len(mean)

    def _constants(self, initial: Any) -> tuple[tuple[float, ...], Any]:
        """A prior of numbers: a mean of at least one component, and its variances."""
        is_pair = isinstance(initial, Sequence) and len(initial) == 2
        mean = as_numbers(initial[0]) if is_pair else math.nan
        if not isinstance(mean, tuple) or not mean or not all(map(math.isfinite, mean)):
            raise GraphError(
                f"initial of {self.mean!r}: expected (mean, variances), such as ((1.0, 0.0), 9.0), "
                f"or a function, got {initial!r}."
            )
        return mean, initial[1]

    def _prior_belief(self, values: Values) -> tuple[Tensor, Tensor]:
        """What is believed before the first step."""
        if self.prior is None:
            return self.prior_mean, self.prior_covariance
        mean, covariance = self.prior(values)
        return mean, covariance

    def _predicted_mean(
        self, values: Values, differentiable: bool = False
    ) -> tuple[Tensor, Tensor | None]:
        """x⁻ = f(x, u) and F = ∂f/∂x, where None stands for the identity."""
        # x⁻ = x + B u: F is the identity, and products with it are left out.
        if isinstance(self.predict, Affine) and self.predict.factors.get(self.mean) == 1:
            return self.predict(values), None
        return self.predict.linearize(values, self.mean, self.size, differentiable)

    def _predicted_covariance(self, values: Values, transition: Tensor | None) -> Tensor:
        """P⁻ = F P Fᵀ + Q."""
        covariance = values[self.covariance]
        if transition is not None:
            covariance = transition @ covariance @ transition.mT
        noise: Tensor = self.noise(values)
        return covariance + noise

    def _corrections(
        self, values: Values, mean: Tensor, covariance: Tensor
    ) -> tuple[Tensor, Tensor, list[Innovation]]:
        """The belief after the measurements, and what they were corrected by."""
        mean, covariance = self._begun_anew(values, mean, covariance)
        return self._corrected(self._measurements, values, mean, covariance)

    def _corrected(
        self, measurements: Sequence[Measurement], values: Values, mean: Tensor, covariance: Tensor
    ) -> tuple[Tensor, Tensor, list[Innovation]]:
        """The belief after some measurements; those absent or beyond the gate change nothing."""
        innovations: list[Innovation] = []

        # One after the other, each from the belief that the last one left.
        for measurement in measurements:
            belief = {**values, self.mean: mean, self.covariance: covariance}
            residual, jacobian, noise = measurement.innovation(belief, self.mean)
            correction = Correction.by(covariance, jacobian, noise)
            mean_change = correction.of_mean(residual)
            corrected = correction.corrected(covariance, jacobian, noise)

            # A reading that is absent or refused changes nothing in its row.
            distance = partial(correction.squared_distance, residual)
            present = measurement.present(values)
            accepted = measurement.accepted(values, distance)
            told = (residual, correction.spread, accepted, present, measurement.gate)
            innovations.append(Innovation(measurement.inputs, *told))
            if accepted is not None:
                mean_change = torch.where(accepted[..., None], mean_change, 0.0)
                corrected = torch.where(accepted[..., None, None], corrected, covariance)

            mean, covariance = mean - mean_change, corrected

        return mean, covariance, innovations

    def _begun_anew(
        self, values: Values, mean: Tensor, covariance: Tensor
    ) -> tuple[Tensor, Tensor]:
        """The belief, or that before the first step in rows whose sensor is somewhere else now.

        A prior that no reading tells leaves the mean where it is.
        """
        # As where a landmark was moved: four readings agree with each other, not with the belief.
        sensors = [name for measurement in self._measurements for name in measurement.inputs]
        for sensor in dict.fromkeys(sensors):
            if sensor + RESTART not in values:
                continue

            prior_mean, prior_covariance = self._prior_belief(values)
            is_restart = values[sensor + RESTART]
            covariance = torch.where(is_restart[..., None, None], prior_covariance, covariance)
            if sensor in self.prior_inputs:
                mean = torch.where(is_restart[..., None], prior_mean, mean)
        return mean, covariance

    def _anticipate_covariance(self, measurement: Measurement, belief: Values) -> Tensor:
        """The covariance after the next measurement, whatever it reads."""
        covariance = belief[self.covariance]
        jacobian = measurement.residual.jacobian(
            belief, self.mean, measurement.size, differentiable=True
        )
        noise = measurement.uncertainty(belief, differentiable=True)
        return Correction.by(covariance, jacobian, noise).corrected(covariance, jacobian, noise)

    def _anticipate_belief(self, measurement: Measurement, belief: Values) -> tuple[Tensor, Tensor]:
        """Mean and covariance after the next measurement, taken to read what was read last."""
        mean, covariance = belief[self.mean], belief[self.covariance]
        residual, jacobian, noise = measurement.innovation(belief, self.mean, differentiable=True)
        correction = Correction.by(covariance, jacobian, noise)
        mean_change = correction.of_mean(residual, self.derivative == "detached_gain")
        return mean - mean_change, correction.corrected(covariance, jacobian, noise)
