"""The named values: before the first step, and after every estimator ran once."""

from collections.abc import Mapping, Sequence

from torch import Tensor

from aicon_torch.differentiation import values_only
from aicon_torch.estimation import Estimator
from aicon_torch.estimation.measurement import Innovation
from aicon_torch.graph.checks import attempt
from aicon_torch.graph.declaration import Declaration
from aicon_torch.graph.order import in_order


@values_only
def initial_values(
    declaration: Declaration,
    estimators: Sequence[Estimator],
    readings: Mapping[str, Tensor],
    batch: tuple[int, ...],
    like: Tensor,
) -> dict[str, Tensor]:
    """Values before the first step: actions at rest, beliefs at their priors, and ``dt``.

    Args:
        declaration: The parts.
        estimators: The estimators in the order in which they run.
        readings: The first readings, ``(*B, size)`` each.
        batch: The leading dimensions B.
        like: A tensor of the wanted type and device.
    """
    values: dict[str, Tensor] = {**readings, "dt": like.new_tensor(declaration.dt)}

    # Nothing was done yet.
    for name, actuator in declaration.actuators.items():
        values[name] = like.new_zeros(*batch, actuator.size)

    # What remembers begins with its prior.
    for estimator in estimators:
        prior = attempt(estimator, estimator.initial, values)
        for name, value in prior.items():
            # Priors may lack the batch. A mean has one dimension of its own, a covariance two.
            own_dimensions = 2 if name in estimator.covariances else 1
            values[name] = value.expand((*batch, *value.shape[-own_dimensions:]))

    # What does not remember follows from it.
    memoryless = [estimator for estimator in estimators if not estimator.recursive]
    for estimator in in_order(memoryless):
        values |= attempt(estimator, estimator.update, values)

    return values


def updated_values(
    declaration: Declaration,
    estimators: Sequence[Estimator],
    values: Mapping[str, Tensor],
    like: Tensor,
) -> tuple[dict[str, Tensor], dict[str, Innovation]]:
    """The values after every estimator ran once, and the innovations that corrected them.

    Args:
        declaration: The parts.
        estimators: The estimators in the order in which they run.
        values: Readings of this step, last actions, and estimates of the last step.
        like: A tensor of the wanted type and device.
    """
    # Estimators take the time that the step took, everything else the time of a step to come.
    dt = like.new_tensor(declaration.dt)
    new = {**values, "dt": dt if declaration.clock is None else values[declaration.clock]}

    corrected: dict[str, Innovation] = {}
    for estimator in estimators:
        updated, innovations = estimator.filtered(new)
        new.update(updated)
        for place, innovation in enumerate(innovations):
            corrected[f"{estimator.outputs[0]}.measurements.{place}"] = innovation
    return {**new, "dt": dt}, corrected
