"""Innovations: by how much readings differ from what an estimator expected them to be."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray

from aicon_torch import EKF, WorldModel
from aicon_torch.estimation import Innovation
from aicon_torch.quantities import AGE, FROZEN, PRESENT
from aicon_torch.resolution import Memory


@dataclass(frozen=True)
class Innovations:
    """The innovations of one measurement over n steps.

    Of a filter whose model and noises are right they are white, with mean 0 and variance 1 a
    component (Bar-Shalom, Li and Kirubarajan, "Estimation with Applications to Tracking and
    Navigation", 2001, section 5.4).

    Attributes:
        estimate: Name of the mean that the measurement corrects.
        readings: The sensors that it reads; none for a relation that holds without a reading.
        whitened: L⁻¹ν with S = L Lᵀ, (n, m); NaN where there was no reading or it was refused.
    """

    estimate: str
    readings: tuple[str, ...]
    whitened: NDArray[np.float64]

    @property
    def squared(self) -> NDArray[np.float64]:
        """The normalised innovation squared by its size, νᵀS⁻¹ν/m, (n,); 1 is expected."""
        squared: NDArray[np.float64] = (self.whitened**2).mean(axis=-1)
        return squared


def innovations(model: WorldModel, memory: Memory) -> list[Innovations]:
    """The innovations of all Kalman filters in an episode.

    Args:
        model: The world model.
        memory: The memories of n steps, as a batch (n,).
    """
    before = {key: value[:-1] for key, value in memory.items()}
    after = {key: value[1:] for key, value in memory.items()}

    # What the first estimator sees: the values of the last step and the new readings.
    values = model.values(before)
    if model.clock is not None:
        values["dt"] = after[model.clock]
    for sensor in model.sensors:
        for key in (sensor, *(sensor + suffix for suffix in (PRESENT, AGE, FROZEN))):
            if key in after:
                values[key] = after[key]

    # Each of the next ones sees what those before it have made of them.
    found: list[Innovations] = []
    for estimator in model.estimators:
        if isinstance(estimator, EKF):
            measured = estimator.innovations(values)
            found.extend(_to_arrays(model, estimator.mean, measured))
        values |= {name: after[name] for name in estimator.outputs}
    return found


def _to_arrays(
    model: WorldModel, estimate: str, measured: list[Innovation]
) -> Iterator[Innovations]:
    for innovation in measured:
        factor, _ = torch.linalg.cholesky_ex(innovation.spread)
        residual = innovation.residual.unsqueeze(-1)
        whitened = torch.linalg.solve_triangular(factor, residual, upper=False).squeeze(-1)
        if innovation.accepted is not None:
            whitened = torch.where(innovation.accepted[..., None], whitened, torch.nan)

        # The first step has no step before it.
        first = whitened.new_full((1, whitened.shape[-1]), torch.nan)
        curve = torch.cat((first, whitened)).numpy(force=True).astype(np.float64)
        readings = tuple(name for name in innovation.inputs if name in model.sensors)
        yield Innovations(estimate, readings, curve)
