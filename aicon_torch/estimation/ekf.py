"""Recursive estimators: modules that own quantities, update them, and say how they will change.

An estimator does two things in a step. ``update`` filters: it takes the last action and the new readings and returns
the new values; no gradient flows there. ``forward`` anticipates: from the new values it gives the quantities that one
more step would bring, differentiable by what moves them. So the values are the measurement's and the gradient is the
model's, evaluated at the best current belief.
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import cast

import torch
from torch import Tensor, nn

from aicon_torch.errors import GraphError, choices
from aicon_torch.estimation.measurement import Correction, Covariance, Derivative, Measurement, Noise
from aicon_torch.interconnections import Affine, Interconnection, Node, Values


class Estimator(Node):
    """Base of all estimators.

    Attributes:
        outputs: Names of the quantities it owns.
        inputs: Names of what it reads. Its own outputs among them mean the values before the step.
        covariances: Those of its outputs that are covariances of others.
        is_motion: Whether its outputs are motions themselves (see :class:`Quantity`).
        recursive: Whether it remembers its last values. Without, ``update`` and ``forward`` give the same value.
        each: Quantities with rows, for each row of which it is evaluated; its outputs then have rows as well.
        prior_inputs: What its initial values are read off.
    """

    outputs: tuple[str, ...]
    inputs: tuple[str, ...]
    covariances: tuple[str, ...] = ()
    is_motion: bool = False
    recursive: bool = True
    each: tuple[str, ...] = ()
    prior_inputs: tuple[str, ...] = ()

    def initial(self, values: Values) -> dict[str, Tensor]:
        """Values of the outputs before the first step, from the first readings."""
        raise NotImplementedError

    def prepare(self, values: Values, optional: Sequence[str], flag: str) -> None:
        """Learn what the graph knows, once, when it is built.

        Args:
            values: A point at which to check what the user gave.
            optional: Sensors that may be absent.
            flag: Suffix of the name of the flag ``(*B,)`` that says whether such a sensor has a reading.
        """

    def update(self, values: Values) -> dict[str, Tensor]:
        """The new values of the outputs, from the values before the step, the last action and the readings."""
        raise NotImplementedError

    def forward(self, values: Values, output: str) -> Tensor:
        """One of the outputs one step ahead, differentiable by the values that require a gradient."""
        raise NotImplementedError


class Deterministic(Estimator):
    """A memoryless estimator y = f(x): an explicit interconnection that defines a quantity.

    Args:
        name: Name of the quantity.
        function: f; its parameter names are the quantities that it reads.
        is_motion: Whether the quantity is itself a motion, such as a displacement.
        each: Quantities ``(*B, N, k)`` for each row of which f is evaluated, so that f is written for one row and the
            quantity is ``(*B, N, n)``. Each row is a path of its own to whatever else f reads.

    Example:
        >>> def move(a, dt):
        ...     return a * dt  # m
        >>> Deterministic("x_rob", move, is_motion=True)
    """

    recursive = False

    def __init__(
        self,
        name: str,
        function: Callable[..., Tensor] | Interconnection,
        *,
        is_motion: bool = False,
        each: Sequence[str] = (),
    ) -> None:
        super().__init__()
        self.relation = Interconnection.of(function)
        self.outputs = (name,)
        self.inputs = self.relation.inputs
        if isinstance(each, str):
            raise GraphError(f"Deterministic {name!r}: each={each!r}; expected a sequence of names, such as [{each!r}].")
        self.each = tuple(each)
        for rows in self.each:
            if rows not in self.inputs or rows == "dt":
                raise GraphError(f"Deterministic {name!r}: each={rows!r}, but it reads {choices(self.inputs)}.")
        if name in self.inputs:
            raise GraphError(f"Deterministic {name!r} reads itself; what remembers its last value is an EKF or a KalmanFilter.")
        self.is_motion = is_motion

    def initial(self, values: Values) -> dict[str, Tensor]:
        """Nothing is remembered."""
        return {}

    @torch.no_grad()
    def update(self, values: Values) -> dict[str, Tensor]:
        """The value ``(*B, n)``."""
        return {self.outputs[0]: self(values, self.outputs[0])}

    def forward(self, values: Values, output: str) -> Tensor:
        """The value, differentiable. With ``each``, a value may come with a copy for each row, or without."""
        if self.each:
            dim = cast(Tensor, values[self.each[0]]).dim()
            read = {name: values[name] for name in self.inputs}
            values = {n: x.unsqueeze(-2) if isinstance(x, Tensor) and x.dim() < dim else x for n, x in read.items()}
        return cast(Tensor, self.relation(values))


class EKF(Estimator):
    """An extended Kalman filter with implicit measurements: a Gaussian belief N(x, P).

    Predict: x⁻ = f(x, u), P⁻ = F P Fᵀ + Q. Correct, one measurement after the other: with ν = h(x⁻, z),
    S = H P⁻ Hᵀ + R, K = P⁻ Hᵀ S⁻¹: x = x⁻ − Kν, P = P⁻ − K S Kᵀ. F and H are derivatives by autograd.

    Args:
        mean: Name of x, ``(*B, n)``.
        covariance: Name of P, ``(*B, n, n)``.
        predict: f, a function that reads ``mean`` and whatever moves it.
        noise: Variances of Q, per step.
        initial: ``(mean, variances)``, or a function of the first readings that returns x ``(*B, n)`` and
            P ``(*B, n, n)``.
        correct: The measurements.
        derivative: Which derivative ``forward`` gives the mean: ``"model"``, that of f, as if the correction were
            noise; ``"update"``, that of the whole next update, readings held; ``"detached_gain"``, the same with K
            held.
        size: Number n of components, needed where ``initial`` is a function.

    Example:
        >>> EKF("p_tar", "P_tar", predict=approach, noise=1e-6, initial=((5.0, 0.0), 9.0), correct=[bearing])
    """

    def __init__(
        self,
        mean: str,
        covariance: str,
        *,
        predict: Callable[..., Tensor] | Interconnection,
        noise: Noise,
        initial: tuple[Sequence[float], float | Sequence[float]] | Callable[..., tuple[Tensor, Tensor]],
        correct: Sequence[Measurement] = (),
        derivative: Derivative = "model",
        size: int | None = None,
    ) -> None:
        super().__init__()
        self.mean, self.covariance = mean, covariance
        self.predict = Interconnection.of(predict)
        if mean not in self.predict.inputs:
            raise GraphError(f"predict of {mean!r} reads {choices(self.predict.inputs)}; it must read {mean!r}.")
        self.size = self._prior(initial, size)
        self.noise = Covariance(noise, self.size)
        self.measurements = nn.ModuleList(correct)
        for measurement in correct:
            if mean not in measurement.residual.inputs:
                reads = choices(measurement.residual.inputs)
                raise GraphError(f"A measurement of {mean!r} reads {reads}; it must read {mean!r}.")
        if derivative not in ("model", "update", "detached_gain"):
            raise GraphError(f"derivative={derivative!r}: expected 'model', 'update' or 'detached_gain'.")
        self.derivative: Derivative = derivative
        self.outputs = (mean, covariance)
        self.covariances = (covariance,)
        parts: list[tuple[str, ...]] = [(mean, covariance), self.predict.inputs, self.noise.inputs, self.prior_inputs]
        parts += [measurement.inputs for measurement in correct]
        self.inputs = tuple(dict.fromkeys(name for part in parts for name in part))

    def _prior(
        self,
        initial: tuple[Sequence[float], float | Sequence[float]] | Callable[..., tuple[Tensor, Tensor]],
        size: int | None,
    ) -> int:
        if callable(initial):
            if size is None:
                raise GraphError(f"{self.mean!r}: a function as initial= needs size=, the number of components.")
            self.prior: Callable[..., tuple[Tensor, Tensor]] | None = initial
            self.prior_inputs = Interconnection(cast(Callable[..., Tensor], initial)).inputs
            return size
        mean, variances = initial
        self.prior, self.prior_inputs = None, ()
        self.register_buffer("prior_mean", torch.as_tensor(mean, dtype=torch.float64))
        self.register_buffer("prior_covariance", cast(Tensor, Covariance(variances, len(mean)).constant))
        return len(mean)

    def initial(self, values: Values) -> dict[str, Tensor]:
        """The prior belief; constants broadcast over the batch."""
        if self.prior is not None:
            mean, covariance = self.prior(*(values[name] for name in self.prior_inputs))
        else:
            mean, covariance = cast(Tensor, self.prior_mean), cast(Tensor, self.prior_covariance)
        return {self.mean: mean, self.covariance: covariance}

    @torch.no_grad()
    def update(self, values: Values) -> dict[str, Tensor]:
        """Predict and correct; readings that are NaN or beyond the gate are left out, row by row."""
        mean, transition = self._transition(values)
        covariance = self._propagate(values, transition)
        for measurement in self._measurements:
            now = {**values, self.mean: mean, self.covariance: covariance}
            residual, jacobian, noise = measurement.innovation(now, self.mean)
            step = Correction.by(covariance, jacobian, noise)
            change, shrink = step.of_mean(residual), step.of_covariance()
            accepted = measurement.accepted(values, partial(step.distance, residual))
            if accepted is not None:
                change = torch.where(accepted.unsqueeze(-1), change, 0.0)
                shrink = torch.where(accepted.unsqueeze(-1).unsqueeze(-1), shrink, 0.0)
            mean, covariance = mean - change, covariance - shrink
        return {self.mean: mean, self.covariance: covariance}

    def forward(self, values: Values, output: str) -> Tensor:
        """The belief one step ahead: the moved mean, or the covariance after measuring from there."""
        if output == self.mean and self.derivative == "model":
            return cast(Tensor, self.predict(values))
        mean, transition = self._transition(values, differentiable=True)
        covariance = self._propagate(values, transition)
        for measurement in self._measurements:
            now = {**values, self.mean: mean, self.covariance: covariance}
            drops = measurement.gate is not None and not measurement.gate_keeps_gradient
            if self.derivative == "model" and not drops:  # the reading itself is of no use
                jacobian = measurement.residual.slope(now, self.mean, measurement.size, differentiable=True)
                step = Correction.by(covariance, jacobian, measurement.uncertainty(now, differentiable=True))
                covariance = covariance - step.of_covariance()
                continue
            residual, jacobian, noise = measurement.innovation(now, self.mean, differentiable=True)
            step = Correction.by(covariance, jacobian, noise)
            change, shrink = step.of_mean(residual, self.derivative == "detached_gain"), step.of_covariance()
            if drops:
                refused = step.distance(residual) > cast(float, measurement.gate)
                change = torch.where(refused.unsqueeze(-1), 0.0, change)
                shrink = torch.where(refused.unsqueeze(-1).unsqueeze(-1), 0.0, shrink)
            mean = mean if self.derivative == "model" else mean - change
            covariance = covariance - shrink
        return mean if output == self.mean else covariance

    @property
    def _measurements(self) -> Sequence[Measurement]:
        return cast(Sequence[Measurement], self.measurements)

    def prepare(self, values: Values, optional: Sequence[str], flag: str) -> None:
        """Note which readings may be absent, and compare the Jacobians that the user gave with autograd's.

        Raises:
            GraphError: If one differs.
        """
        for measurement in self._measurements:
            shape = tuple(measurement.residual(values).shape)
            if shape[-1] != measurement.size:
                raise GraphError(
                    f"A measurement of {self.mean!r} by {choices(measurement.residual.inputs)} has a residual of "
                    f"{shape[-1]} components; expected size={measurement.size}."
                )
            measurement.optional = tuple(name + flag for name in measurement.inputs if name in optional)
            measurement.residual.verify(values, measurement.size)
        self.predict.verify(values, self.size)

    def _transition(self, values: Values, differentiable: bool = False) -> tuple[Tensor, Tensor | None]:
        """The predicted mean f and F = ∂f/∂x, where None stands for the identity."""
        if isinstance(self.predict, Affine) and self.predict.factors.get(self.mean) == 1:
            return self.predict(values), None
        return self.predict.linearize(values, self.mean, self.size, differentiable)

    def _propagate(self, values: Values, transition: Tensor | None) -> Tensor:
        """P⁻ = F P Fᵀ + Q."""
        covariance = cast(Tensor, values[self.covariance])
        if transition is not None:
            covariance = transition @ covariance @ transition.mT
        return covariance + cast(Tensor, self.noise(values))


class KalmanFilter(EKF):
    """A Kalman filter: an :class:`EKF` whose prediction and measurements are :class:`Affine`, so nothing is linearised.

    Args:
        mean: Name of x.
        covariance: Name of P.
        predict: ``Affine(x=A, u=B)``.
        noise: Variances of Q, per step.
        initial: Mean and variances before the first step.
        correct: Measurements whose residual is Affine, such as ``Affine(x=1.0, z=-1.0)``.

    Example:
        >>> KalmanFilter("x", "P", predict=Affine(x=1.0, a=0.05), noise=1e-6, initial=((0.0, 0.0), 1.0),
        ...        correct=[Measurement(Affine(x=1.0, z=-1.0), noise=0.01, size=2)])
    """

    def __init__(
        self,
        mean: str,
        covariance: str,
        *,
        predict: Affine,
        noise: Noise,
        initial: tuple[Sequence[float], float | Sequence[float]],
        correct: Sequence[Measurement] = (),
    ) -> None:
        if not isinstance(predict, Affine) or not all(isinstance(m.residual, Affine) for m in correct):
            raise GraphError(f"KalmanFilter {mean!r}: prediction and measurements must be Affine; an EKF takes any function.")
        super().__init__(mean, covariance, predict=predict, noise=noise, initial=initial, correct=correct)
