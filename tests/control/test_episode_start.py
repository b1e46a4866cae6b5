"""Rows that start an episode forget; the others go on."""

from typing import Any

import numpy as np
import pytest
import torch
from _asserts import assert_same_memory, rollout
from _inputs import drifting, navigation
from _inputs.shipped import quick

from aicon_torch import ObservationError


@pytest.mark.parametrize("kind", [np.array, list, torch.tensor])
def test_only_the_rows_that_start_forget(kind: Any) -> None:
    policy, recorded = navigation(), drifting(41, (3,))
    memory = rollout(policy, recorded[:40])[-1]

    start = kind([False, True, False])
    _, after = policy.predict(recorded[40], memory, episode_start=start)
    _, going_on = policy.predict(recorded[40], memory)
    _, anew = policy.predict(recorded[40])

    for key, value in after.items():
        torch.testing.assert_close(value[0], going_on[key][0])
        torch.testing.assert_close(value[2], going_on[key][2])
        torch.testing.assert_close(value[1], anew[key][1])

    assert not torch.equal(after["p_tar"][1], going_on["p_tar"][1])


@pytest.mark.parametrize(
    "start", [True, np.True_, np.array(True), np.array([True]), torch.tensor(True)], ids=repr
)
def test_a_single_robot_may_start_anew(start: Any) -> None:
    """Without batch dimensions too, and with the one-row array that one environment's loop has."""
    policy, recorded = navigation(), drifting(21)
    memory = rollout(policy, recorded[:20])[-1]

    _, after = policy.predict(recorded[20], memory, episode_start=start)
    assert_same_memory(after, policy.predict(recorded[20])[1], 0.0)


@pytest.mark.parametrize("start", [False, np.array([False]), [False], None])
def test_without_a_start_it_goes_on(start: Any) -> None:
    policy, recorded = navigation(), drifting(21)
    memory = rollout(policy, recorded[:20])[-1]

    _, after = policy.predict(recorded[20], memory, episode_start=start)
    assert_same_memory(after, policy.predict(recorded[20], memory)[1], 0.0)


def test_the_first_memory_ignores_episode_start() -> None:
    (reading,) = drifting(1, (3,))
    _, expected = navigation().predict(reading)

    for start in (np.ones(3, bool), np.zeros(3, bool), None):
        _, memory = navigation().predict(reading, None, start)
        assert_same_memory(memory, expected, 0.0)


@pytest.mark.parametrize("start", [np.zeros(3, dtype=bool), []], ids=["three", "none"])
def test_one_robot_has_one_start_compiled_or_not(start: Any) -> None:
    compiled, recorded = quick(navigation()), drifting(2)
    for policy in (navigation(), compiled):
        _, memory = policy.predict(recorded[0])
        with pytest.raises(ObservationError, match="episode_start"):
            policy.predict(recorded[1], memory, episode_start=start)


def test_a_start_of_another_batch_is_named() -> None:
    (reading,) = drifting(1, (3,))
    _, memory = navigation().predict(reading)
    with pytest.raises(ObservationError, match=r"episode_start.*\(3,\).*\(2,\)"):
        navigation().predict(reading, memory, episode_start=np.ones(2, dtype=bool))
