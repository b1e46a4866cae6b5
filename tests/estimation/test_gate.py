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


@pytest.mark.parametrize("keeps", [True, False])
def test_the_gate_can_keep_the_gradient_of_the_covariance(keeps: bool) -> None:
    refused, believed = beacon_values(z=REFUSED), beacon_values(z=BELIEVED)
    node = beacon(correct=[Measurement(bearing, 0.04, gate=2.0, gate_keeps_gradient=keeps)])

    torch.testing.assert_close(slopes(node, "P", believed), slopes(beacon(), "P", believed))

    kept = slopes(node, "P", refused)
    expected = slopes(beacon(), "P", refused) if keeps else torch.zeros_like(kept)
    torch.testing.assert_close(kept, expected)


@pytest.mark.parametrize("keeps", [True, False])
@pytest.mark.parametrize("derivative", ["update", "detached_gain"])
def test_a_refused_reading_shapes_the_mean_no_more_than_the_covariance(
    derivative: Any, keeps: bool
) -> None:
    refused = beacon_values(z=REFUSED)
    measurement = Measurement(bearing, 0.04, gate=2.0, gate_keeps_gradient=keeps)

    got = slopes(beacon(correct=[measurement], derivative=derivative), "x", refused)
    expected = slopes(beacon(derivative=derivative if keeps else "model"), "x", refused)
    torch.testing.assert_close(got, expected)
