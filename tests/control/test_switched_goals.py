"""Goals that are switched off, on, and weighted."""

import numpy as np
import pytest
import torch
from _asserts import assert_same_memory, rollout
from _inputs import drifting, navigation, observation_with

from aicon_torch import OptionError


def test_a_goal_can_be_switched_off_and_on() -> None:
    policy, recorded = navigation("potential_field"), drifting(3)
    memory = rollout(policy, recorded[:2])[-1]
    off = policy.predict(recorded[2], policy.switch(memory, avoid=False))[1]
    gradients = off["x_rob/gradients"]

    assert [bool(gradient.any()) for gradient in gradients] == [
        "avoid" not in str(arrival) for arrival in policy.backward_pass.arrivals["x_rob"]
    ]

    on = policy.predict(recorded[2], policy.switch(policy.switch(memory, avoid=False), avoid=True))[
        1
    ]
    assert_same_memory(on, policy.predict(recorded[2], memory)[1], 0.0)

    nothing = policy.predict(recorded[2], policy.switch(memory, avoid=False, reach=0.0))[1]
    assert not nothing["a/gradient"].any()


def test_a_switch_stays_until_changed_and_is_of_each_row() -> None:
    policy, recorded = navigation("aicon"), drifting(60, (2,))
    memory = rollout(policy, recorded[:40])[-1]
    memory = policy.switch(memory, avoid=torch.tensor([0.0, 1.0]))
    expected = rollout(policy, recorded)

    for reading, whole in zip(recorded[40:], expected[40:], strict=True):
        _, memory = policy.predict(reading, memory)
        torch.testing.assert_close(memory["a"][1], whole["a"][1])

    assert not torch.allclose(memory["a"][0], expected[-1]["a"][0])


def test_a_switch_outlasts_the_episode() -> None:
    policy, recorded = navigation("aicon"), drifting(5, (2,))
    memory = policy.switch(rollout(policy, recorded[:4])[-1], avoid=0.0)
    _, after = policy.predict(recorded[4], memory, episode_start=np.array([True, False]))

    assert torch.equal(after["goals/active"], memory["goals/active"])
    assert not after["x_rob/gradients"][
        :, [str(a) for a in policy.backward_pass.arrivals["x_rob"]].index("avoid → x_obs")
    ].any()


def test_an_unknown_goal_is_named() -> None:
    _, memory = navigation("aicon").predict(observation_with())
    with pytest.raises(OptionError, match=r"'reech'.*'reach', 'avoid'"):
        navigation("aicon").switch(memory, reech=False)


def test_a_goal_about_uncertainty_can_be_descended_alone() -> None:
    """Seen along one axis only, the robot moves so as to see the other.

    The paper's triangulation.
    """
    policy, reading = navigation("potential_field"), drifting(2)
    memory = rollout(policy, reading)[-1]
    slope = memory["x_rob/gradients"][
        [str(arrival) for arrival in policy.backward_pass.arrivals["x_rob"]].index("reach → P_tar")
    ]
    across = torch.tensor([-memory["p_tar"][1], memory["p_tar"][0]]).double()

    assert (slope @ across).abs() > 3.0 * (slope @ memory["p_tar"]).abs()
