"""Estimators in general: learned parts, and what is no estimator."""

from typing import Any

import numpy as np
import pytest
import torch
from _inputs import beacon, drive
from torch import Tensor, nn

from aicon_torch import (
    EKF,
    Actuator,
    Deterministic,
    DirectDescent,
    Goal,
    GraphError,
    Interconnection,
    KalmanFilter,
    Measurement,
    Policy,
    Sensor,
    Sum,
    WorldModel,
)


def residual(x: Tensor, z: Tensor) -> Tensor:
    return x - z


class Learned(nn.Module):
    def __init__(self) -> None:
        super().__init__()
        self.scale = nn.Parameter(torch.tensor([0.1, 0.2], dtype=torch.float64))

    def forward(self, z: Tensor) -> Tensor:
        return self.scale**2 + 0.01 * z**2


def test_parameters_of_the_user_leave_no_graph_in_the_memory() -> None:
    track = EKF(
        "x",
        "P",
        predict=drive,
        noise=Learned(),
        initial=((0.5, -0.5), 2.0),
        correct=[Measurement(residual, 1.0, size=2)],
    )
    model = WorldModel(
        sensors={"z": Sensor(2, "m")},
        actuators={"a": Actuator(2, "m")},
        estimators=[track, Deterministic("y", Interconnection(Learned(), inputs=("x",)))],
        goals=[Goal("g", lambda x, y: (x * y).sum(-1))],
        dtype=torch.float64,
    )

    policy = Policy(model, Sum(), DirectDescent(0.1))
    _, memory = policy.predict({"z": np.ones(2)})
    _, memory = policy.predict({"z": np.ones(2)}, memory)

    assert not any(value.requires_grad for value in memory.values())
    assert len(list(policy.parameters())) == 2


@pytest.mark.parametrize(
    ("make", "culprit"),
    [
        (lambda: Deterministic("x", lambda x: x), "'x' reads itself"),
        (
            lambda: EKF("x", "P", predict=lambda y: y, noise=1.0, initial=((0.0,), 1.0)),
            "'x' reads 'y'; it must read 'x'",
        ),
        (
            lambda: beacon(correct=[Measurement(lambda y, z: y - z, 1.0)]),
            "A measurement of 'x' reads 'y', 'z'",
        ),
        (
            lambda: beacon(derivative="exact"),
            "'exact': expected 'model', 'update' or 'detached_gain'",
        ),
        (lambda: beacon(initial=lambda z: (z, z)), "'x': .*size="),
        (lambda: beacon(noise=(1.0, 2.0, 3.0)), "noise"),
        (lambda: beacon(initial=((0.0, 0.0), (1.0, 1.0, 1.0))), "noise|variance"),
        (
            lambda: KalmanFilter("x", "P", predict=drive, noise=1.0, initial=((0.0,), 1.0)),  # type: ignore[arg-type]
            "'x': prediction and measurements must be Affine",
        ),
    ],
)
def test_a_bad_estimator_is_named(make: Any, culprit: str) -> None:
    with pytest.raises(GraphError, match=culprit):
        make()
