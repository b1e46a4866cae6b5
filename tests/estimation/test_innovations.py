"""Innovations are what an update corrects by, and white where model and noises are right."""

import pytest
import torch
from _inputs.beacon import beacon, beacon_values

from aicon_torch import Affine, KalmanFilter, Measurement
from aicon_torch.estimation import Correction

STEPS = 2_000


def test_an_update_corrects_by_the_innovation() -> None:
    ekf, values = beacon(), beacon_values((3,))
    (innovation,) = ekf.innovations(values)

    blind = beacon(correct=[]).update(values)  # the prediction alone
    jacobian = ekf.measurements[0].residual.jacobian({**values, "x": blind["x"]}, "x", 1)
    correction = Correction.by(blind["P"], jacobian, torch.full((3, 1, 1), 0.04).double())

    expected = blind["x"] - correction.of_mean(innovation.residual)
    torch.testing.assert_close(ekf.update(values)["x"], expected)
    torch.testing.assert_close(innovation.spread, correction.spread)


def test_they_are_white_where_model_and_noises_are_right() -> None:
    generator = torch.Generator().manual_seed(0)
    kalman = KalmanFilter(
        "x", "P", predict=Affine(x=1.0), noise=0.04, initial=((0.0,), 1.0),
        correct=[Measurement(Affine(x=1.0, z=-1.0), noise=0.25)],
    )  # fmt: skip
    values = {"x": torch.zeros(1), "P": torch.eye(1)}
    truth, squared = torch.zeros(1), []

    for _ in range(STEPS):
        truth = truth + 0.2 * torch.randn(1, generator=generator)
        values["z"] = truth + 0.5 * torch.randn(1, generator=generator)
        (innovation,) = kalman.innovations(values)
        squared.append(float(innovation.residual**2 / innovation.spread))
        values |= kalman.update(values)

    assert sum(squared) / STEPS == pytest.approx(1.0, abs=0.1)
