"""The named values before the first step, and values to try a graph at."""

from collections.abc import Collection, Mapping, Sequence

import torch
from torch import Tensor

from aicon_torch.differentiation import values_only
from aicon_torch.estimation import Estimator
from aicon_torch.graph.checks import outputs_of
from aicon_torch.graph.declaration import Declaration
from aicon_torch.graph.order import in_order


def scattered_values(values: Mapping[str, Tensor], fixed: Collection[str]) -> dict[str, Tensor]:
    """The values with random numbers from 0.5 to 1.5, the same at every run, but for fixed ones.

    Args:
        values: Values of a step.
        fixed: Names of what stays as it is; so do flags.
    """
    generator = torch.Generator("cpu").manual_seed(0)
    point = dict(values)
    for name, value in values.items():
        if value.is_floating_point() and name not in fixed:
            noise = torch.rand(value.shape, generator=generator, dtype=value.dtype, device="cpu")
            point[name] = (noise + 0.5).to(value.device)
    return point


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
