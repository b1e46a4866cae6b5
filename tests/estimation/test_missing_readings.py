"""Readings that are missing or late, in a graph."""

from typing import Any

import numpy as np
import pytest
import torch
from _inputs import drive
from torch import Tensor

from aicon_torch import (
    EKF,
    Actuator,
    DirectDescent,
    Goal,
    Measurement,
    Policy,
    Sensor,
    Sum,
    WorldModel,
)


def residual(x: Tensor, z: Tensor) -> Tensor:
    return x - z


def tracker(noise: Any = 0.1, **options: Any) -> Policy:
    """A point is seen now and then; another sensor tells how old the reading is."""
    track = EKF(
        "x",
        "P",
        predict=drive,
        noise=0.05,
        initial=((0.5, -0.5), 2.0),
        correct=[Measurement(residual, noise, size=2, **options)],
    )
    model = WorldModel(
        sensors={"z": Sensor(2, "m", optional=True), "age": Sensor(1, "s")},
        actuators={"a": Actuator(2, "m")},
        estimators=[track],
        goals=[Goal("near", lambda x: (x**2).sum(-1)), Goal("far", lambda x: -x[..., 0])],
        dtype=torch.float64,
    )
    return Policy(model, Sum(), DirectDescent(0.1))


NEW = {"age": np.zeros(1)}
SEEN = NEW | {"z": np.array([1.0, 1.0])}
MISSING = {
    "no key": NEW,
    "NaN": NEW | {"z": np.array([np.nan, np.nan])},
    "one NaN": NEW | {"z": np.array([0.0, np.nan])},
}


@pytest.mark.parametrize("missing", MISSING.values(), ids=MISSING.keys())
def test_without_a_reading_the_filter_predicts(missing: dict[str, Any]) -> None:
    policy = tracker()
    _, memory = policy.predict(SEEN)
    action, after = policy.predict(missing, memory)

    noise = 0.05 * torch.eye(2, dtype=torch.float64)
    torch.testing.assert_close(after["x"], drive(memory["x"], memory["a"]))
    torch.testing.assert_close(after["P"], memory["P"] + noise)
    assert np.isfinite(action).all()
    assert all(value.isfinite().all() for value in after.values())

    _, again = policy.predict(SEEN, after)
    assert again["P"].diagonal().sum() < after["P"].diagonal().sum()


def test_an_episode_may_begin_without_a_reading() -> None:
    action, memory = tracker().predict(NEW)
    torch.testing.assert_close(memory["x"], torch.tensor([0.5, -0.5], dtype=torch.float64))
    assert np.isfinite(action).all()


def test_rows_miss_readings_alone() -> None:
    policy = tracker()
    z = np.array([[1.0, 1.0], [np.nan, 1.0], [2.0, 0.0]])
    age = np.zeros((3, 1))
    _, memory = policy.predict({"z": np.ones((3, 2)), "age": age})
    _, together = policy.predict({"z": z, "age": age}, memory)

    for row in range(3):
        memory_of_row = {key: value[row] for key, value in memory.items()}
        _, alone = policy.predict({"z": z[row], "age": age[row]}, memory_of_row)

        torch.testing.assert_close(alone["x"], together["x"][row])
        torch.testing.assert_close(alone["P"], together["P"][row])


@pytest.mark.parametrize("age", [0.0, 0.4, 5.0])
def test_late_readings_count_less(age: float) -> None:
    """The noise is a function of the age of the reading."""

    def stale(age: Tensor) -> Tensor:
        return (0.1 + age) * torch.ones(2, dtype=age.dtype)

    _, memory = tracker(noise=stale).predict({"z": np.array([2.0, 1.0]), "age": np.array([age])})

    gain = 2.05 / (2.05 + 0.1 + age)
    expected = torch.tensor([0.5 + gain * 1.5, -0.5 + gain * 1.5], dtype=torch.float64)
    torch.testing.assert_close(memory["x"], expected)


def test_a_gated_filter_survives_a_missing_reading() -> None:
    policy = tracker(gate=9.0)
    _, memory = policy.predict(SEEN)

    _, outlier = policy.predict(NEW | {"z": np.array([1e6, 1e6])}, memory)
    _, missing = policy.predict(NEW, memory)
    torch.testing.assert_close(outlier["x"], missing["x"])
