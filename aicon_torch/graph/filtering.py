"""Filtering a log: the estimates of a graph over whole episodes, differentiable through time."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import torch
from torch import Tensor, nn

from aicon_torch.differentiation import through_time
from aicon_torch.errors import GraphError, ObservationError, choices
from aicon_torch.estimation import Innovation
from aicon_torch.graph.build import Graph
from aicon_torch.graph.declaration import Declaration
from aicon_torch.graph.values import initial_values
from aicon_torch.quantities import AGE, RESTART, as_count
from aicon_torch.readings.validation import BEGINS, MeasurementValidation

Named = Mapping[str, Tensor]
"""Tensors by name."""


PROBE_STEPS = 3
"""Steps after which what learns must have had an effect."""


@dataclass(frozen=True)
class Innovations:
    """By how much the readings of T steps differed from what one measurement expected.

    Attributes:
        residual: ν, ``(*B, T, m)``.
        spread: S, ``(*B, T, m, m)``.
        counts: Which tell something, ``(*B, T)``: not those that are absent, nor those by which an
            estimate began, which it agrees with anyhow.
        gate: νᵀS⁻¹ν beyond which a reading is not believed.
    """

    residual: Tensor
    spread: Tensor
    counts: Tensor
    gate: float | None

    def log_likelihood(self) -> Tensor:
        """Log N(ν; 0, S) of each step, ``(*B, T)``, zero where nothing is told.

        What the gate refuses counts as if it were at the gate: otherwise a filter that refuses
        everything would be the likeliest.
        """
        # A step that does not count is no reason for NaN: it takes ν = 0, S = I.
        size, counts = self.residual.shape[-1], self.counts.unsqueeze(-1)
        residual = torch.where(counts, self.residual, 0.0)
        identity = torch.eye(size, dtype=residual.dtype, device=residual.device)
        spread = torch.where(counts.unsqueeze(-1), self.spread, identity)

        # With S = L Lᵀ: νᵀS⁻¹ν = ‖L⁻¹ν‖², and log det S = 2 Σ log Lᵢᵢ.
        factor = torch.linalg.cholesky_ex(spread).L
        whitened = torch.linalg.solve_triangular(factor, residual.unsqueeze(-1), upper=False)
        distance = whitened.square().sum((-2, -1))
        if self.gate is not None:
            distance = distance.clamp(max=self.gate)
        log_volume = 2 * factor.diagonal(dim1=-2, dim2=-1).log().sum(-1)

        log_density = -0.5 * (distance + log_volume + size * math.log(2 * math.pi))
        return torch.where(self.counts, log_density, 0.0)


@dataclass(frozen=True)
class Filtered:
    """What a graph made of T steps of readings.

    Attributes:
        estimates: Each estimate after every reading, ``(*B, T, *shape)``.
        innovations: Of each measurement, by the name of its estimate and its place there, such as
            ``"x_pose.measurements.0"``.
    """

    estimates: dict[str, Tensor]
    innovations: dict[str, Innovations]

    def log_likelihood(self) -> Tensor:
        """Log-likelihood Σ −½ (νᵀS⁻¹ν + log det 2πS) of the readings (Schweppe 1965), ``(*B,)``."""
        steps = [innovations.log_likelihood() for innovations in self.innovations.values()]
        return torch.stack(steps).sum((0, -1))

    def readings(self) -> Tensor:
        """How many readings tell something, ``(*B,)``: what a likelihood is divided by."""
        counts = [innovations.counts.sum(-1) for innovations in self.innovations.values()]
        return torch.stack(counts).sum(0)


class LogFilter(NamedTuple):
    """Runs the estimators of a graph over a log, as a policy does while somebody else acts.

    Attributes:
        declaration: The parts.
        graph: What runs in which order.
        like: A tensor of the model's type and device.
    """

    declaration: Declaration
    graph: Graph
    like: Tensor

    def __call__(self, readings: Named, actions: Named, truncate: int | None) -> Filtered:
        """See :meth:`aicon_torch.WorldModel.filter`."""
        if truncate is not None and as_count(truncate) < 1:
            raise ObservationError(f"truncate={truncate!r}: expected 1 or more steps, or None.")
        seen, executed, batch = self._checked(readings, actions)
        estimates: dict[str, list[Tensor]] = {name: [] for name in self.graph.owners}
        told: dict[str, list[tuple[Innovation, Tensor]]] = {}

        with through_time():
            memory = self._beginning(seen[0], batch)
            for step, reading in enumerate(seen):
                # Rows that have not begun do so with the first readings that they need.
                begins = memory[BEGINS]
                if step > 0:
                    memory = _begun(memory, self._beginning(reading, batch), begins)
                    memory |= executed[step - 1]
                if truncate is not None and step > 0 and step % truncate == 0:
                    memory = {name: value.detach() for name, value in memory.items()}  # as asked

                # Predict and correct.
                memory |= self._validation(reading, memory)
                memory, corrected = self._updated(memory)
                for name, innovation in corrected.items():
                    counts = self._counts(name, innovation, memory, begins)
                    told.setdefault(name, []).append((innovation, counts))
                for name, series in estimates.items():
                    series.append(memory[name])

        by_step = {name: torch.stack(series, dim=len(batch)) for name, series in estimates.items()}
        return Filtered(by_step, {name: _series(series) for name, series in told.items()})

    @property
    def _validation(self) -> MeasurementValidation:
        """Which readings are believed."""
        declared = self.declaration
        return MeasurementValidation(
            declared.sensors,
            declared.actuators,
            self.graph.first_readings,
            declared.dt,
            declared.clock,
        )

    def _checked(
        self, readings: Named, actions: Named
    ) -> tuple[list[dict[str, Tensor]], list[dict[str, Tensor]], tuple[int, ...]]:
        """Readings and actions of each step, and the batch."""
        self._check_all_named(readings, actions)
        first = next(name for name in self.declaration.sensors if name in readings)
        leading = tuple(_tensor(first, readings[first]).shape[:-1])
        seen = self._seen(readings, leading)
        executed = self._executed(actions, leading)

        # What an observation would report of the actions, they tell already.
        for name, actuator in self.declaration.actuators.items():
            if actuator.key is not None:
                seen[name] = torch.full_like(executed[name], torch.nan)
        return _by_step(seen, leading), _by_step(executed, leading), leading[:-1]

    def _check_all_named(self, readings: Named, actions: Named) -> None:
        """Everything that is given is in the graph, and everything that it needs is given."""
        sensors, actuators = self.declaration.sensors, self.declaration.actuators
        ages = [name + AGE for name, sensor in sensors.items() if sensor.is_aged]
        _check_names("readings", readings, (*sensors, *ages))
        _check_names("actions", actions, tuple(actuators))

        needed = [name for name, sensor in sensors.items() if not sensor.optional]
        for name in (*needed, *actuators):
            if name not in readings and name not in actions:
                raise ObservationError(f"filter: {name!r} is missing, (*batch, steps, size).")
        if not any(name in readings for name in sensors):
            raise ObservationError(f"readings: expected a series of one of {choices(sensors)}.")

    def _seen(self, readings: Named, leading: tuple[int, ...]) -> dict[str, Tensor]:
        """The series of all sensors, ``(*B, T, size)``, and of their ages, ``(*B, T)``."""
        seen: dict[str, Tensor] = {}
        for name, sensor in self.declaration.sensors.items():
            seen[name] = self._of_shape(name, readings.get(name), (*leading, sensor.size))
            if sensor.is_aged:
                age = _tensor(name + AGE, readings.get(name + AGE, sensor.age)).to(self.like)
                if tuple(age.shape) not in ((), leading):
                    raise ObservationError(
                        f"{name + AGE!r}: expected (*batch, steps), here {leading}, got "
                        f"{tuple(age.shape)}."
                    )
                seen[name + AGE] = age.expand(leading)
        return seen

    def _executed(self, actions: Named, leading: tuple[int, ...]) -> dict[str, Tensor]:
        """The series of all actions, ``(*B, T, size)``."""
        executed: dict[str, Tensor] = {}
        for name, actuator in self.declaration.actuators.items():
            executed[name] = self._of_shape(name, actions[name], (*leading, actuator.size))
            if not executed[name].isfinite().all():
                raise ObservationError(f"actions: {name!r} must be finite; at rest it is zero.")
        return executed

    def _of_shape(self, name: str, given: Tensor | None, shape: tuple[int, ...]) -> Tensor:
        """A series of the model's type; NaN where none is given."""
        if given is None:
            return self.like.new_full(shape, torch.nan)
        series = _tensor(name, given).to(self.like)
        if tuple(series.shape) != shape or len(shape) < 2 or not shape[-2]:
            raise ObservationError(
                f"{name!r}: expected (*batch, steps, size), here {shape}, got "
                f"{tuple(series.shape)}."
            )
        return series

    def _beginning(self, reading: Named, batch: tuple[int, ...]) -> dict[str, Tensor]:
        """The values before a first step with these readings."""
        estimators, first = self.graph.estimators, self._validation.first(reading)
        memory = initial_values(self.declaration, estimators, first, batch, self.like)
        for key, value in self._validation.initial().items():
            dtype = self.like.dtype if value.is_floating_point() else value.dtype
            memory[key] = value.to(self.like.device, dtype).expand((*batch, *value.shape))
        return memory

    def _updated(
        self, values: dict[str, Tensor]
    ) -> tuple[dict[str, Tensor], dict[str, Innovation]]:
        """The values after every estimator ran once, and what corrected them."""
        # The clock's time is that of the step that was; what is to come takes dt.
        clock, dt = self.declaration.clock, self.like.new_tensor(self.declaration.dt)
        new = {**values, "dt": dt if clock is None else values[clock]}
        corrected: dict[str, Innovation] = {}
        for estimator in self.graph.estimators:
            updated, innovations = estimator.filtered(new)
            new.update(updated)
            for place, innovation in enumerate(innovations):
                corrected[f"{estimator.outputs[0]}.measurements.{place}"] = innovation
        return {**new, "dt": dt}, corrected

    def _counts(self, name: str, innovation: Innovation, values: Named, begins: Tensor) -> Tensor:
        """Where an innovation tells something, ``(*B,)``."""
        counts = ~values[BEGINS]
        if innovation.present is not None:
            counts = counts & innovation.present

        # An estimate that began at a reading, or began anew, agrees with it.
        owner = self.graph.owners[name.partition(".")[0]]
        for sensor in set(innovation.inputs).intersection(owner.prior_inputs):
            counts = counts & ~begins & ~values.get(sensor + RESTART, torch.zeros_like(begins))
        return counts


def check_effect(
    declaration: Declaration, graph: Graph, parameters: Mapping[str, nn.Parameter], like: Tensor
) -> None:
    """Check that each parameter has an effect on what is estimated, expected or wanted.

    Raises:
        GraphError: If nothing is differentiable by it.
    """
    generator = torch.Generator("cpu").manual_seed(0)

    def random(size: int) -> Tensor:
        # Away from zero, where a derivative may vanish by accident.
        numbers = torch.rand((PROBE_STEPS, size), generator=generator, dtype=torch.float64)
        return (0.1 + numbers).to(like)

    # 1. Filter a short log of numbers drawn at random, ...
    sizes = {name: sensor.size for name, sensor in declaration.sensors.items()}
    readings = {name: random(size) for name, size in sizes.items()}
    actions = {name: random(actuator.size) for name, actuator in declaration.actuators.items()}
    filtered = LogFilter(declaration, graph, like)(readings, actions, None)

    # 2. look one step ahead from its end, ...
    with through_time():
        last = {name: series[-1] for name, series in filtered.estimates.items()}
        last |= {name: series[-1] for name, series in (readings | actions).items()}
        last["dt"] = like.new_tensor(declaration.dt)
        ahead = [estimator(last, name) for name, estimator in graph.owners.items()]
        costs = [goal(last) for goal in declaration.goals.values()]
        limited = [f(last) for name in actions for f in declaration.functions_of(name)]

        # 3. and see whether any of it can be differentiated by each parameter.
        found = [*filtered.estimates.values(), *ahead, *costs, *limited]
        for innovations in filtered.innovations.values():
            found += [innovations.residual, innovations.spread]
        total = torch.stack([value.sum() for value in found]).sum()

    # Where nothing learns at all, autograd would fail before it is told which number does not.
    if not total.requires_grad:
        total = total.clone().requires_grad_()
    effects = torch.autograd.grad(total, list(parameters.values()), allow_unused=True)
    for name, effect in zip(parameters, effects, strict=True):
        if effect is None:
            raise GraphError(
                f"{name!r} cannot learn: nothing that is estimated, expected or wanted can be "
                "differentiated by it."
            )


def _check_names(kind: str, given: Named, known: tuple[str, ...]) -> None:
    """Everything that is given is in the graph."""
    if not isinstance(given, Mapping):
        raise ObservationError(f"{kind}: expected series by name ({choices(known)}).")
    for name in given:
        if name not in known:
            raise ObservationError(f"{kind}: there is no {name!r}. Known: {choices(known)}.")


def _tensor(name: str, given: Any) -> Tensor:
    """A series as a tensor."""
    try:
        return torch.as_tensor(given)
    except (TypeError, ValueError, RuntimeError) as error:
        raise ObservationError(
            f"{name!r}: expected numbers (*batch, steps, size); {error}."
        ) from error


def _by_step(series: Named, leading: tuple[int, ...]) -> list[dict[str, Tensor]]:
    """Series ``(*B, T, …)`` with the leading dimensions (*B, T), taken apart into T steps."""
    *batch, steps = leading
    found: list[dict[str, Tensor]] = []
    for step in range(steps):
        found.append({name: value.select(len(batch), step) for name, value in series.items()})
    return found


def _begun(memory: Named, fresh: Named, begins: Tensor) -> dict[str, Tensor]:
    """The memory, and a fresh one in rows ``(*B,)`` that have not begun."""
    if not begins.any():
        return dict(memory)
    chosen: dict[str, Tensor] = {}
    for name, value in memory.items():
        # A row's flag holds for all of its numbers; dt is one for all rows.
        own = (None,) * (value.dim() - begins.dim())
        is_one_for_all = name == "dt"
        flags = begins[(..., *own)]
        chosen[name] = value if is_one_for_all else torch.where(flags, fresh[name], value)
    return chosen


def _series(told: list[tuple[Innovation, Tensor]]) -> Innovations:
    """The innovations of one measurement, step by step."""
    axis, gate = told[0][1].dim(), told[0][0].gate
    counts = torch.stack([counts for _, counts in told], dim=axis)
    residual = torch.stack([innovation.residual for innovation, _ in told], dim=axis)
    spreads: list[Tensor] = []
    for innovation, _ in told:
        # S lacks the batch where nothing in it differs from row to row.
        own = innovation.spread.shape[-2:]
        spreads.append(innovation.spread.expand(*counts.shape[:axis], *own))
    return Innovations(residual, torch.stack(spreads, dim=axis), counts, gate)
