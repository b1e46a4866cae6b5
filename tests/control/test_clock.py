"""A clock tells how long a step took: estimates, ages and gates go by it."""

import math

import numpy as np
import pytest
import torch
from _asserts import assert_same_steps
from _inputs import drifting, lean, navigation
from torch import Tensor

from aicon_torch import Deterministic, Goal, GraphError, Policy, Sensor, WorldModel
from aicon_torch.parts import clock
from aicon_torch.quantities import AGE

DT = 0.05
LATE = lean("nav2d", delay=4)
Reading = dict[str, Tensor]


def timed(reading: Reading, *elapsed: float) -> Reading:
    """A reading of rows that took so long, or of one robot."""
    times = torch.tensor(elapsed, dtype=torch.float64).unsqueeze(-1)
    return reading | {"elapsed": times[0] if len(elapsed) == 1 else times}


@pytest.mark.parametrize("policy", [navigation(), LATE], ids=["prompt", "late"])
def test_who_does_not_tell_took_as_long_as_usual(policy: Policy) -> None:
    memory = told_memory = None
    for reading in drifting(8):
        action, memory = policy.predict(reading, memory)
        told, told_memory = policy.predict(timed(reading, DT), told_memory)
        assert np.array_equal(action, told)
    assert memory is not None and told_memory is not None
    assert policy.explain(memory).alerts == ()
    for key in set(memory) - {"z_elapsed.present", "z_elapsed.age", "z_elapsed.missed"}:
        assert torch.equal(memory[key], told_memory[key]), key


def test_a_longer_step_moves_the_estimates_farther_row_by_row() -> None:
    policy, recorded = navigation(), drifting(3, (3,))
    _, memory = policy.predict(recorded[0])
    _, memory = policy.predict(recorded[1], memory)
    _, after = policy.predict(timed(recorded[2], DT, 2 * DT, 0.0), memory)

    way = memory["a"] * torch.tensor([[DT], [2 * DT], [0.0]], dtype=torch.float64)
    torch.testing.assert_close(after["x_rob"], way, rtol=1e-12, atol=0)


def test_what_reads_the_time_is_built_on_one_time_a_row() -> None:
    """As the clock tells it in a step: a function that takes it for a scalar is named at once."""

    def far(a: Tensor, dt: Tensor) -> Tensor:
        return a * torch.stack((dt, dt))

    model = navigation().model
    sensors = {"z": Sensor(2, "m"), "z_elapsed": clock()}
    moved = Deterministic("d", far, is_motion=True)
    with pytest.raises(GraphError, match="'d'"):
        WorldModel(
            sensors=sensors,
            actuators=model.actuators,
            estimators=[moved],
            goals=[Goal("g", lambda d: d.square().sum(-1))],
            dt=DT,
            clock="z_elapsed",
            dtype=torch.float64,
        )


def test_ages_grow_by_what_has_passed() -> None:
    policy, recorded = navigation(), drifting(2)
    _, memory = policy.predict(recorded[0])
    missing = {key: torch.full_like(value, math.nan) for key, value in recorded[1].items()}
    _, after = policy.predict(timed(missing, 3 * DT), memory)
    assert after["z_tar" + AGE] == pytest.approx(3 * DT)


def test_a_reading_may_have_gone_as_far_as_the_time_allows() -> None:
    """In one step the bearing cannot turn by 0.8 rad; in nine it can."""
    policy, recorded = navigation(), drifting(2)
    _, memory = policy.predict(recorded[0])
    turned = recorded[0] | {"bearing": recorded[0]["bearing"] + 0.8, "range": recorded[1]["range"]}
    _, soon = policy.predict(turned, memory)
    _, later = policy.predict(timed(turned, 9 * DT), memory)
    assert not soon["z_tar.present"] and later["z_tar.present"]


@pytest.mark.parametrize("wrong", [math.nan, -0.1, math.inf])
def test_a_clock_that_cannot_be_right_is_not_believed(wrong: float) -> None:
    policy, recorded = navigation(), drifting(2)
    _, memory = policy.predict(recorded[0])
    expected, _ = policy.predict(recorded[1], memory)
    action, after = policy.predict(timed(recorded[1], wrong), memory)
    assert np.array_equal(action, expected) and after["z_elapsed"] == DT


@pytest.mark.parametrize("stall", [10.1 * DT, 1.0, 10.0, 1e9])
def test_a_stall_moves_no_estimate_but_makes_readings_older(stall: float) -> None:
    """What the robot did meanwhile is not known: without a new reading it stands."""
    policy, recorded = navigation(), drifting(3)
    _, memory = policy.predict(recorded[0])
    _, memory = policy.predict(recorded[1], memory)
    missing = {key: torch.full_like(value, math.nan) for key, value in recorded[2].items()}
    action, after = policy.predict(timed(missing, stall), memory)

    assert torch.equal(after["p_tar"], memory["p_tar"])
    assert after["z_tar" + AGE] == pytest.approx(stall)
    assert (action == 0).all()


def test_after_a_stall_a_new_reading_is_all_that_it_needs() -> None:
    policy, recorded = navigation(), drifting(3)
    _, memory = policy.predict(recorded[0])
    _, memory = policy.predict(recorded[1], memory)
    action, after = policy.predict(timed(recorded[2], 1.0), memory)
    assert after["z_tar" + AGE] == 0.0 and (action != 0).any()


@pytest.mark.parametrize("policy", [navigation(), LATE], ids=["prompt", "late"])
def test_compiled_it_goes_by_the_clock_as_well(policy: Policy) -> None:
    steps = [1, 3, 2, 1, 11, 2, 200, 1]
    readings = [
        timed(reading, DT * count, DT, 0.5 * DT * count)
        for reading, count in zip(drifting(len(steps), (3,)), steps, strict=True)
    ]
    assert_same_steps(policy, policy.compile(), readings)


def test_a_clock_is_a_sensor_of_one_number() -> None:
    model = navigation().model
    parts = {
        "actuators": model.actuators,
        "estimators": list(model.estimators),
        "goals": list(model.goals.values()),
    }
    with pytest.raises(GraphError, match=r"clock='tick': expected a sensor: .*'z_elapsed'"):
        WorldModel(sensors=model.sensors, clock="tick", **parts)
    wide = {**model.sensors, "z_elapsed": Sensor(2, "s")}
    with pytest.raises(GraphError, match=r"clock='z_elapsed': .* 2 components; expected one, in s"):
        WorldModel(sensors=wide, clock="z_elapsed", **parts)
