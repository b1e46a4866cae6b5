"""Goals that are switched off, on, and weighted."""

from typing import Any

import numpy as np
import pytest
import torch
from _asserts import arrived, assert_same_memory, rollout
from _inputs import drifting, navigation, observation_with

from aicon_torch import OptionError


def test_a_goal_can_be_switched_off_and_on() -> None:
    policy, recorded = navigation("potential_field"), drifting(3)
    memory = rollout(policy, recorded[:2])[-1]
    switched_off = policy.switch(memory, avoid=False)

    _, off = policy.predict(recorded[2], switched_off)
    for path, gradient in arrived(policy, off, "x_rob").items():
        assert bool(gradient.any()) == ("avoid" not in path)

    _, on = policy.predict(recorded[2], policy.switch(switched_off, avoid=True))
    assert_same_memory(on, policy.predict(recorded[2], memory)[1], 0.0)

    _, nothing = policy.predict(recorded[2], policy.switch(memory, avoid=False, reach=0.0))
    assert not nothing["a/gradient"].any()


def test_a_switch_stays_until_changed_and_is_of_each_row() -> None:
    policy, recorded = navigation(), drifting(60, (2,))
    expected = rollout(policy, recorded)
    memory = policy.switch(expected[39], avoid=torch.tensor([0.0, 1.0]))

    for reading, unswitched in zip(recorded[40:], expected[40:], strict=True):
        _, memory = policy.predict(reading, memory)
        torch.testing.assert_close(memory["a"][1], unswitched["a"][1])

    assert not torch.allclose(memory["a"][0], expected[-1]["a"][0])


def test_a_switch_outlasts_the_episode() -> None:
    policy, recorded = navigation(), drifting(5, (2,))
    memory = policy.switch(rollout(policy, recorded[:4])[-1], avoid=0.0)

    _, after = policy.predict(recorded[4], memory, episode_start=np.array([True, False]))
    assert torch.equal(after["goals/active"], memory["goals/active"])
    assert not arrived(policy, after, "x_rob")["avoid → x_obs → x_rob"].any()


@pytest.mark.parametrize("factor", [0, np.array([0.0]), torch.zeros(1), False])
def test_one_factor_is_for_all_rows(factor: Any) -> None:
    policy, (reading,) = navigation(), drifting(1, (3,))
    _, memory = policy.predict(reading)
    assert policy.switch(memory, avoid=factor)["goals/active"][:, 1].tolist() == [0.0] * 3


@pytest.mark.parametrize("factor", [float("nan"), float("inf"), -1.0, "1", torch.ones(5), None])
def test_a_factor_that_is_none_is_named(factor: Any) -> None:
    policy = navigation()
    _, memory = policy.predict(observation_with())
    with pytest.raises(OptionError, match="avoid=.*: expected a finite factor >= 0"):
        policy.switch(memory, avoid=factor)


def test_an_unknown_goal_is_named() -> None:
    _, memory = navigation().predict(observation_with())
    with pytest.raises(OptionError, match=r"'reech'.*'reach', 'avoid'"):
        navigation().switch(memory, reech=False)


def test_a_goal_about_uncertainty_can_be_descended_alone() -> None:
    """Seen along one axis only, the robot moves so as to see the other.

    The paper's triangulation.
    """
    policy = navigation("potential_field")
    memory = rollout(policy, drifting(2))[-1]
    slope = arrived(policy, memory, "x_rob")["reach → P_tar → x_rob"]

    along = memory["p_tar"]
    across = torch.stack((-along[1], along[0]))
    assert (slope @ across).abs() > 3.0 * (slope @ along).abs()
