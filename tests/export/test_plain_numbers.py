"""Numbers of numpy and torch are kept as plain ones, which a file can tell."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from _inputs.following import distance, moved
from torch import Tensor

from aicon_torch import (
    Actuator,
    Affine,
    Deterministic,
    Goal,
    GraphError,
    LateEKF,
    Measurement,
    Policy,
    Sensor,
    WorldModel,
    load_exported,
)
from aicon_torch.export.codegen import has_compiler

TENTH = np.float32(0.1)
TWO = np.int64(2)


MATCH = Affine(p=1.0, z=-1.0)


def late(**changes: Any) -> LateEKF:
    """A filter with some of its arguments changed."""
    own: dict[str, Any] = {
        "sensor": "z",
        "steps": TWO,
        "moved_by": {"x": TWO},
        "predict": Affine(p=1.0, x=-1.0),
        "noise": TENTH,
        "initial": ((1.0, 0.0), 1.0),
    }
    return LateEKF("p", "P", **{**own, **changes})


def of_reading(z: Tensor) -> tuple[Tensor, Tensor]:
    """A prior that is the first reading."""
    return z, torch.diag_embed(torch.ones_like(z))


def of_scalars() -> WorldModel:
    """A model of which every number is one of numpy or torch."""
    match = Measurement(MATCH, noise=TENTH, size=TWO, gate=np.float32(9.0))
    reach = torch.tensor([1.0, 1.5], dtype=torch.bfloat16, requires_grad=True)
    ends = (-np.float32(9.0), torch.tensor(9.0))

    return WorldModel(
        sensors={"z": Sensor(TWO, "m", optional=True, age=TENTH, range=ends, max_age=TENTH * 9)},
        actuators={"a": Actuator(TWO, "m/s", limit=reach, command_range=np.array([-1, 1], "f4"))},
        estimators=[
            Deterministic("x", moved, is_motion=True),
            late(correct=[match]),
        ],
        goals=[Goal("near", distance, tolerance=TENTH)],
        dt=TENTH,
    )


def test_numbers_become_plain_ones() -> None:
    model = of_scalars()
    sensor, actuator, measurement = model.sensors["z"], model.actuators["a"], model.estimators[1]
    numbers = [model.dt, sensor.age, *sensor.range, *actuator.limit, *actuator.command_range]
    numbers += [model.goals["near"].tolerance, measurement.measurements[0].gate]
    assert {type(number) for number in numbers} == {float}
    sizes = [sensor.size, actuator.size, measurement.steps, *measurement.moved_by.values()]
    assert {type(size) for size in sizes} == {int}
    assert actuator.limit == (1.0, 1.5)


@pytest.mark.parametrize(
    ("wrong", "what"),
    [
        (lambda: Measurement(MATCH, 0.1, size=2.5), "Measurement size 2.5: expected 1 or more"),
        (lambda: Measurement(MATCH, 0.1, size="2"), "Measurement size '2': expected 1 or more"),
        (lambda: Measurement(MATCH, 0.1, gate="9"), "Measurement gate='9': expected a number"),
        (lambda: late(steps=2.7), "steps=2.7 of 'p': expected a number of steps >= 0"),
        (lambda: late(moved_by={"x": 2.7}), "moved_by of 'p': 'x' size 2.7: expected 1 or more"),
        (lambda: late(initial=of_reading, size=2.5), "'p' size 2.5: expected 1 or more"),
    ],
)
def test_what_is_no_such_number_is_named(wrong: Callable[[], object], what: str) -> None:
    with pytest.raises(GraphError, match=what):
        wrong()


@pytest.mark.skipif(not has_compiler(), reason="there is no C compiler")
def test_a_model_of_such_numbers_is_exported(tmp_path: Path) -> None:
    policy = Policy(of_scalars())
    policy.export(tmp_path / "policy.so")
    reading = {"z": np.array([1.0, 2.0])}
    expected, _ = policy.predict(reading)
    found, _ = load_exported(tmp_path / "policy.so").predict(reading)
    np.testing.assert_allclose(found, expected, atol=1e-5)
