"""Estimates alone, while somebody else acts."""

from typing import Any

import numpy as np
import pytest
import torch
from _asserts import assert_same_memory
from _inputs import drifting, navigation, observation_with, two_robots
from torch import Tensor

from aicon_torch import (
    Actuator,
    Deterministic,
    DirectDescent,
    Goal,
    ObservationError,
    OptionError,
    Policy,
    Sensor,
    Sum,
    WorldModel,
)


def test_estimates_without_acting_are_those_of_predict() -> None:
    policy, recorded = navigation(), drifting(60, (2,))
    memory = watching = None

    for reading in recorded:
        executed = None if memory is None else {"a": memory["a"]}
        watching = policy.estimate(reading, watching, executed)
        _, memory = policy.predict(reading, memory)
        for name in ("p_tar", "P_tar", "x_obs", "P_obs"):
            assert torch.equal(watching[name], memory[name])

    assert watching is not None and memory is not None and watching.keys() == memory.keys()


def test_acting_can_begin_after_watching() -> None:
    policy, recorded = navigation(), drifting(20)
    executed = {"a": torch.tensor([0.1, 0.0], dtype=torch.float64)}

    memory = None
    for reading in recorded[:10]:
        memory = policy.estimate(reading, memory, executed)

    _, after = policy.predict(recorded[10], memory)
    assert after["a"].isfinite().all()
    assert memory is not None and after.keys() == memory.keys()


def test_the_given_action_moves_the_estimates() -> None:
    policy, recorded = navigation(), drifting(2)
    start = policy.estimate(recorded[0])

    executed = {"a": torch.tensor([0.5, 0.0], dtype=torch.float64)}
    moved = policy.estimate(recorded[1], start, executed)
    assert torch.equal(moved["x_rob"], torch.tensor([0.025, 0.0], dtype=torch.float64))

    at_rest = policy.estimate(recorded[1], start)
    assert not at_rest["x_rob"].any()


def test_estimation_starts_episodes_too() -> None:
    policy, recorded = navigation(), drifting(11, (2,))
    last = recorded.pop()

    memory = None
    for reading in recorded:
        memory = policy.estimate(reading, memory)

    after = policy.estimate(last, memory, episode_start=np.array([True, False]))
    anew, going_on = policy.estimate(last), policy.estimate(last, memory)
    torch.testing.assert_close(after["p_tar"][0], anew["p_tar"][0])
    torch.testing.assert_close(after["p_tar"][1], going_on["p_tar"][1])


LAWS = [DirectDescent(1.0), DirectDescent(1.0, accumulate=True), DirectDescent(1.0, smoothing=0.0)]


@pytest.mark.parametrize("limit", [0.5, (0.5, 0.3)], ids=str)
@pytest.mark.parametrize("law", LAWS, ids=str)
def test_the_limit_holds_after_somebody_else_was_faster(limit: Any, law: DirectDescent) -> None:
    model = WorldModel(
        sensors={"z": Sensor(2, "m")},
        actuators={"a": Actuator(2, "m/s", limit)},
        estimators=[Deterministic("x", lambda a, z: a + z)],
        goals=[Goal("reach", lambda x: (x**2).sum(-1))],
        dtype=torch.float64,
    )

    policy, reading = Policy(model, Sum(), law), {"z": np.ones(2)}

    executed = {"a": torch.tensor([30.0, -40.0], dtype=torch.float64)}
    pushed = policy.estimate(reading, action=executed)
    action, _ = policy.predict(reading, pushed)

    assert (np.abs(action) <= 0.5).all()
    assert np.linalg.norm(action) <= np.linalg.norm(limit) + 1e-6


def test_what_was_executed_may_come_as_predict_gives_it() -> None:
    """In numpy and in single precision."""
    policy, reading = navigation(), observation_with()
    action, memory = policy.predict(reading)
    told = policy.estimate(reading, memory, action={"a": action.astype(np.float32)})
    torch.testing.assert_close(told["a"], torch.as_tensor(action).to(told["a"]))


def test_an_action_for_each_row_is_needed() -> None:
    reading = {key: np.stack((value,) * 3) for key, value in observation_with().items()}
    with pytest.raises(ObservationError, match=r"shape \(3, 2\)"):
        navigation().estimate(reading, action={"a": np.zeros(2)})


def test_an_unknown_actuator_is_named() -> None:
    with pytest.raises(OptionError, match=r"'v'.*'a'"):
        navigation().estimate(observation_with(), action={"v": torch.zeros(2)})


@pytest.mark.parametrize(
    "action", [torch.zeros(3), torch.tensor([0.0, torch.nan]), torch.tensor([torch.inf, 0.0])]
)
def test_an_executed_action_that_cannot_be_is_named(action: Tensor) -> None:
    with pytest.raises(ObservationError, match=r"'a'.*finite values of shape \(2,\)"):
        navigation().estimate(observation_with(), action={"a": action})


def test_an_action_needs_no_name_where_there_is_one_actuator() -> None:
    policy, (first, second) = navigation(), drifting(2)
    _, memory = policy.predict(first)
    executed = np.array([0.1, -0.2])
    named = policy.estimate(second, memory, {"a": executed})
    alone = policy.estimate(second, memory, executed)
    assert_same_memory(alone, named, tolerance=0.0)


def test_an_action_needs_a_name_where_there_are_several_actuators() -> None:
    policy = Policy(two_robots())
    observation = {name: np.zeros(sensor.size) for name, sensor in policy.model.sensors.items()}
    with pytest.raises(OptionError, match="expected what was executed by actuator"):
        policy.estimate(observation, action=np.zeros(2))
