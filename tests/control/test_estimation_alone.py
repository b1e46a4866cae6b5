"""Estimates alone, while somebody else acts."""

from typing import Any

import numpy as np
import pytest
import torch
from _inputs import drifting, navigation, observation_with
from torch import Tensor

from aicon_torch import (
    ActionLaw,
    Actuator,
    Deterministic,
    Goal,
    ObservationError,
    OptionError,
    Policy,
    Sensor,
    Sum,
    WorldModel,
)


def test_estimates_without_acting_are_those_of_predict() -> None:
    policy, recorded = navigation("aicon"), drifting(60, (2,))
    memory = watching = None

    for reading in recorded:
        executed = None if memory is None else {"a": memory["a"]}
        watching = policy.estimate(reading, watching, executed)
        _, memory = policy.predict(reading, memory)
        for name in ("p_tar", "P_tar", "x_obs", "P_obs"):
            torch.testing.assert_close(watching[name], memory[name], rtol=1e-12, atol=1e-12)

    assert watching is not None and memory is not None and watching.keys() == memory.keys()


def test_acting_can_begin_after_watching() -> None:
    policy, recorded = navigation("aicon"), drifting(20)
    memory = None
    for reading in recorded[:10]:
        memory = policy.estimate(
            reading, memory, {"a": torch.tensor([0.1, 0.0], dtype=torch.float64)}
        )
    _, after = policy.predict(recorded[10], memory)

    assert after["a"].isfinite().all()
    assert memory is not None and after.keys() == memory.keys()


def test_the_given_action_moves_the_estimates() -> None:
    policy, recorded = navigation("aicon"), drifting(2)
    start = policy.estimate(recorded[0])
    moved = policy.estimate(
        recorded[1], start, {"a": torch.tensor([0.5, 0.0], dtype=torch.float64)}
    )

    assert torch.equal(moved["x_rob"], torch.tensor([0.025, 0.0], dtype=torch.float64))

    at_rest = policy.estimate(recorded[1], start)
    assert not at_rest["x_rob"].any()


def test_estimation_starts_episodes_too() -> None:
    policy, recorded = navigation("aicon"), drifting(11, (2,))
    memory = None
    for reading in recorded[:10]:
        memory = policy.estimate(reading, memory)
    after = policy.estimate(recorded[10], memory, episode_start=np.array([True, False]))

    torch.testing.assert_close(after["p_tar"][0], policy.estimate(recorded[10])["p_tar"][0])
    torch.testing.assert_close(after["p_tar"][1], policy.estimate(recorded[10], memory)["p_tar"][1])


@pytest.mark.parametrize("limit", [0.5, (0.5, 0.3)], ids=str)
def test_the_limit_holds_after_somebody_else_was_faster(limit: Any) -> None:
    model = WorldModel(
        sensors={"z": Sensor(2, "m")},
        actuators={"a": Actuator(2, "m/s", limit)},
        estimators=[Deterministic("x", lambda a, z: a + z)],
        goals=[Goal("reach", lambda x: (x**2).sum(-1))],
        dtype=torch.float64,
    )

    for law in (ActionLaw(1.0), ActionLaw(1.0, accumulate=True), ActionLaw(1.0, smoothing=0.0)):
        policy = Policy(model, Sum(), law)
        pushed = policy.estimate(
            {"z": np.ones(2)}, action={"a": torch.tensor([30.0, -40.0], dtype=torch.float64)}
        )
        action, _ = policy.predict({"z": np.ones(2)}, pushed)
        assert (np.abs(action) <= 0.5).all() and np.linalg.norm(action) <= np.linalg.norm(
            limit
        ) + 1e-6


def test_an_unknown_actuator_is_named() -> None:
    with pytest.raises(OptionError, match=r"'v'.*'a'"):
        navigation("aicon").estimate(observation_with(), action={"v": torch.zeros(2)})


@pytest.mark.parametrize(
    "action", [torch.zeros(3), torch.tensor([0.0, torch.nan]), torch.tensor([torch.inf, 0.0])]
)
def test_an_executed_action_that_cannot_be_is_named(action: Tensor) -> None:
    with pytest.raises(ObservationError, match=r"'a'.*finite values of shape \(\*batch, 2\)"):
        navigation("aicon").estimate(observation_with(), action={"a": action})
