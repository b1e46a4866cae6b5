"""Whether the rows of a batch stand alone: a function may not look from one robot at another."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager

import torch
from torch import Tensor

from aicon_torch.errors import GraphError
from aicon_torch.estimation import Estimator
from aicon_torch.graph.checks import attempt, outputs_of
from aicon_torch.graph.declaration import Declaration
from aicon_torch.graph.values import scattered_values
from aicon_torch.interconnections import Values


@torch.no_grad()
def check_rows_stand_alone(
    declaration: Declaration, estimators: Sequence[Estimator], values: Mapping[str, Tensor]
) -> None:
    """Evaluate the graph on a batch of different rows, and on some of them alone.

    Args:
        declaration: The parts.
        estimators: The estimators.
        values: Values after a step, with two leading dimensions of 2 or more.

    Raises:
        GraphError: If a function gives a row something else in company.
    """
    together = _different(estimators, values)
    in_company = _evaluated(declaration, estimators, together)

    for index in range(2):
        alone = _evaluated(declaration, estimators, _row(together, index))
        for name, value in _row(in_company, index).items():
            if not _agree(value, alone[name]):
                numbers, others = value.flatten(), alone[name].flatten()
                worst = (numbers.double() - others.double()).abs().argmax()
                raise GraphError(
                    f"{name} mixes the rows of a batch: of the same inputs it has "
                    f"{float(numbers[worst]):.4g} beside other rows where it has "
                    f"{float(others[worst]):.4g} alone. Functions must leave leading dimensions "
                    "free, mean(-1, keepdim=True), not mean(0), and what they read as it is."
                )


def _evaluated(
    declaration: Declaration, estimators: Sequence[Estimator], values: Values
) -> dict[str, Tensor]:
    """What all functions of the graph give at the same values, by what an error calls them."""
    given: dict[str, Tensor] = {}
    for estimator in estimators:
        with _unchanged(estimator.outputs[0], values):
            for name, value in outputs_of(estimator, "update", values).items():
                given[repr(name)] = value
                given[f"{name!r} foreseen"] = estimator(values, name)

    for name, goal in declaration.goals.items():
        with _unchanged(name, values):
            given[repr(name)] = attempt(goal, goal.forward, values)

    for name in declaration.actuators:
        for function in declaration.functions_of(name):
            with _unchanged(name, values):
                given[f"{function.function!r} of actuator {name!r}"] = function(values)
    return given


@contextmanager
def _unchanged(called: str, values: Values) -> Iterator[None]:
    """Check that a function writes nothing into what it reads, which others read as well."""
    before = {name: value._version for name, value in values.items()}
    yield
    for name, value in values.items():
        if value._version != before[name]:
            raise GraphError(
                f"{called!r} changes {name!r} in place, which others read as well: functions must "
                "leave what they read as it is, x.clamp(max=1.0), not x.clamp_(max=1.0)."
            )


def _different(estimators: Sequence[Estimator], values: Mapping[str, Tensor]) -> dict[str, Tensor]:
    """A batch (2, 2) of rows that differ, but for covariances, which cannot be anything."""
    covariances = {name for estimator in estimators for name in estimator.covariances}
    few = {name: value[:2, :2] if value.dim() else value for name, value in values.items()}
    scalars = {name for name, value in few.items() if not value.dim()}
    return scattered_values(few, covariances | scalars)


def _row(values: Mapping[str, Tensor], index: int) -> dict[str, Tensor]:
    """One row of a batch (2, 2), as a batch (1, 1); a scalar such as ``dt`` stays one."""
    row = slice(index, index + 1)
    return {name: value[row, row] if value.dim() else value for name, value in values.items()}


def _agree(one: Tensor, other: Tensor) -> bool:
    """Whether two values are the same but for rounding, which batches may do in another order."""
    one, other = one.double(), other.to(one.device).double()
    tolerance = torch.finfo(torch.float32).eps ** 0.5
    return torch.allclose(one, other, rtol=tolerance, atol=tolerance, equal_nan=True)
