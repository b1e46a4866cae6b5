"""Probing a graph when it is built: one step on zeros shows whether all shapes fit."""

from collections.abc import Mapping, Sequence
from typing import Any

import torch
from torch import Tensor
from torch.masked import is_masked_tensor

from aicon_torch.errors import GraphError
from aicon_torch.estimation import Estimator
from aicon_torch.graph.checks import attempt, named_errors, other_precision, outputs_of
from aicon_torch.graph.declaration import Declaration
from aicon_torch.graph.values import initial_values, scattered_values
from aicon_torch.interconnections import Interconnection
from aicon_torch.quantities import AGE, PRESENT

BATCH = (7, 5)
"""Leading dimensions of the probe: a function that does not leave them free fails here."""


@torch.no_grad()
def probe(
    declaration: Declaration, estimators: Sequence[Estimator], like: Tensor
) -> dict[str, Tensor]:
    """The values after one step on zeros, with batch (7, 5).

    Raises:
        GraphError: If a function cannot be evaluated, or returns a shape that does not fit.
    """
    # Zeros as readings, all of them there and new.
    readings: dict[str, Tensor] = {}
    for name, sensor in declaration.sensors.items():
        readings[name] = like.new_zeros(*BATCH, sensor.size)
        readings[name + AGE] = like.new_zeros(BATCH)
        readings[name + PRESENT] = like.new_ones(BATCH, dtype=torch.bool)

    values = initial_values(declaration, estimators, readings, BATCH, like)

    # One step: every estimator on what those before it gave, with dt as a clock tells it.
    dt = values["dt"]
    if declaration.clock is not None:
        values["dt"] = dt.expand(*BATCH, 1)
    for estimator in estimators:
        with named_errors(estimator, values):
            estimator.check_sizes(values)
        updated = outputs_of(estimator, "update", values)
        for name, value in updated.items():
            _check_shape(name, value, values.get(name, value))
            if value.dtype != like.dtype:
                raise GraphError(f"{name!r} is of {value.dtype}. {other_precision(like.dtype)}")
        values.update(updated)
    values["dt"] = dt

    # What the last values are for.
    _check_foresight(estimators, values)
    _check_sensors(declaration, readings)
    _check_goals(declaration, values)
    _check_actuators(declaration, values)
    return values


def check_at_random_point(
    declaration: Declaration, estimators: Sequence[Estimator], values: Mapping[str, Tensor]
) -> None:
    """Let the estimators check themselves where no value is zero.

    Raises:
        GraphError: If one finds something wrong.
    """
    point = scattered_values(values, ("dt",))  # at zero a wrong Jacobian may look right
    for estimator in estimators:
        estimator.check(point)


def _check_shape(name: str, value: Tensor, earlier: Tensor) -> None:
    """An updated value has the batch in front, a component behind, and the shape it had."""
    has_batch = value.dim() > len(BATCH) and value.shape[: len(BATCH)] == BATCH
    if has_batch and value.shape == earlier.shape:
        return

    own = tuple(earlier.shape[len(BATCH) :]) or "(n,), its components"
    raise GraphError(
        f"{name!r} has shape {tuple(value.shape)} for batch {BATCH}; expected the batch, then "
        f"{own}. Functions must leave leading dimensions free."
    )


def _check_foresight(estimators: Sequence[Estimator], values: Mapping[str, Tensor]) -> None:
    """What is foreseen of an estimate has the estimate's shape."""
    for estimator in estimators:
        for name in estimator.outputs:
            with named_errors(estimator, values):
                ahead: Any = estimator(values, name)
            expected = tuple(values[name].shape)
            if not isinstance(ahead, Tensor) or tuple(ahead.shape) != expected:
                got = tuple(ahead.shape) if isinstance(ahead, Tensor) else type(ahead).__name__
                raise GraphError(
                    f"forward of {type(estimator).__name__} {name!r}: expected a tensor of shape "
                    f"{expected}, as update gives it, got {got}."
                )


def _check_sensors(declaration: Declaration, readings: Mapping[str, Tensor]) -> None:
    """Whether a reading can be is said of each row."""
    for name, sensor in declaration.sensors.items():
        if sensor.is_possible is None:
            continue
        try:
            told: Any = sensor.is_possible(readings[name])
        except (RuntimeError, IndexError, TypeError, ValueError, AttributeError) as error:
            raise GraphError(
                f"is_possible of Sensor {name!r} cannot be evaluated on readings "
                f"{tuple(readings[name].shape)}: {error!r}"
            ) from error

        is_dense = isinstance(told, Tensor) and not is_masked_tensor(told)
        if not is_dense or told.dtype != torch.bool or told.shape != BATCH:
            got = f"{told.dtype} {tuple(told.shape)}" if is_dense else repr(told)
            raise GraphError(
                f"is_possible of Sensor {name!r}: expected a flag for each row of the batch, "
                f"torch.bool {BATCH}, got {got}."
            )


def _check_goals(declaration: Declaration, values: Mapping[str, Tensor]) -> None:
    """A goal's cost is one number for each row of the batch."""
    for name, goal in declaration.goals.items():
        cost = attempt(goal, goal.forward, values)
        if cost.shape != BATCH:
            raise GraphError(
                f"Goal {name!r}: expected a cost of the batch's shape {BATCH}, got "
                f"{tuple(cost.shape)}."
            )


def _check_actuators(declaration: Declaration, values: Mapping[str, Tensor]) -> None:
    """Constraints return an action, metrics and dithers matrices, commands what has the batch."""
    for name in declaration.actuators:
        shape = tuple(values[name].shape)
        for function in declaration.functions_of(name):
            result = _result_shape(name, function, values)
            expected = shape
            if function is declaration.commands.get(name):
                expected = (*BATCH, *result[len(BATCH) :])
            elif function is declaration.metrics.get(name):
                expected = (*shape, shape[-1])
            elif function is declaration.dithers.get(name):
                expected = (*shape, result[-1] if len(result) > len(shape) else 1)

            if result != expected:
                raise GraphError(
                    f"{function.function!r} of actuator {name!r} returns shape {result}; expected "
                    f"{expected}."
                )


def _result_shape(
    actuator: str, function: Interconnection, values: Mapping[str, Tensor]
) -> tuple[int, ...]:
    try:
        return tuple(function(values).shape)
    except (RuntimeError, IndexError, TypeError, ValueError, AttributeError) as error:
        raise GraphError(
            f"{function.function!r} of actuator {actuator!r} cannot be evaluated: {error!r}"
        ) from error
