"""The outlier gate: a reading that is too far from what was expected teaches nothing."""

from typing import Any

import pytest
import torch
from _asserts import beacon_step, slopes, update
from _inputs import beacon, beacon_values, bearing
from torch import Tensor

from aicon_torch import Measurement

REFUSED = torch.tensor([3.0], dtype=torch.float64)
BELIEVED = torch.tensor([0.5], dtype=torch.float64)


def mahalanobis(values: dict[str, Tensor]) -> Tensor:
    """νᵀS⁻¹ν of the beacon's reading, ``(*B,)``, by hand."""
    step = beacon_step(values)
    residual = bearing(step.predicted_mean, values["z"]).squeeze(-1)
    return residual**2 / step.spread.squeeze(-1).squeeze(-1)


def test_the_gate_refuses_outliers_row_by_row() -> None:
    readings = torch.tensor([[0.4], [0.5], [1.0], [2.0], [-2.0], [0.45]], dtype=torch.float64)
    values = beacon_values((6,), z=readings)

    believed = mahalanobis(values) <= 2.0
    assert believed.any() and not believed.all()

    node = beacon(correct=[Measurement(bearing, 0.04, gate=2.0)])
    updated = update(node, values)

    step = beacon_step(values)
    mean = torch.where(believed[:, None], step.mean, step.predicted_mean)
    covariance = torch.where(believed[:, None, None], step.covariance, step.predicted_covariance)
    torch.testing.assert_close(updated["x"], mean)
    torch.testing.assert_close(updated["P"], covariance)


@pytest.mark.parametrize("reading", [REFUSED, BELIEVED])
@pytest.mark.parametrize("derivative", ["model", "update", "detached_gain"])
@pytest.mark.parametrize("output", ["x", "P"])
def test_the_gate_leaves_the_gradients_as_they_are(
    output: str, derivative: Any, reading: Tensor
) -> None:
    values = beacon_values(z=reading)
    gated = beacon(correct=[Measurement(bearing, 0.04, gate=2.0)], derivative=derivative)

    expected = slopes(beacon(derivative=derivative), output, values)
    torch.testing.assert_close(slopes(gated, output, values), expected)
