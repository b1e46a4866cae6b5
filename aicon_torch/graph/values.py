"""The named values before the first step."""

from collections.abc import Mapping, Sequence

from torch import Tensor

from aicon_torch.differentiation import values_only
from aicon_torch.estimation import Estimator
from aicon_torch.graph.checks import outputs_of
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
        prior = outputs_of(estimator, "initial", values, estimator.recursive)
        for name, value in prior.items():
            # Priors may lack the batch. A mean has one dimension of its own, a covariance two.
            own_dimensions = 2 if name in estimator.covariances else 1
            values[name] = value.expand((*batch, *value.shape[-own_dimensions:]))

    # What does not remember follows from it.
    memoryless = [estimator for estimator in estimators if not estimator.recursive]
    for estimator in in_order(memoryless):
        values |= outputs_of(estimator, "update", values)

    return values
