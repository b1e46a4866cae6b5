"""A fourth goal on the navigation graph, without touching a module."""

import functools
import math
from typing import Any

import numpy as np
import torch
from _inputs import drifting, driven, navigation, with_goal
from numpy.typing import NDArray
from torch import Tensor

from aicon_torch import Goal, Policy


def beside(p_tar: Tensor) -> Tensor:
    """Stay in a lane 1 m wide along the x axis through the target."""
    return torch.nn.functional.softplus(8.0 * (p_tar[..., 1].abs() - 0.5))


def extended() -> Policy:
    return with_goal(Goal("lane", beside))


def test_a_fourth_goal_is_one_more_path() -> None:
    policy = extended()
    paths = {str(path) for path in policy.model.paths()}
    before = {str(path) for path in navigation().model.paths()}
    assert paths == {*before, "lane → p_tar → x_rob → a"}

    _, memory = policy.predict(drifting(1)[0])
    quantities = policy.trace(memory).quantities
    assert set(quantities) == {"p_tar", "x_rob", "a"}
    assert quantities["p_tar"].gradients.shape == (2, 2)  # reach and lane meet there
    assert quantities["x_rob"].gradients.shape == (3, 2)


@functools.cache
def in_the_lane() -> Policy:
    """As it is shipped, but for the goal."""
    return driven("nav2d").with_goal(Goal("lane", beside))


def drive(
    lane: bool, steps: int
) -> tuple[Policy, dict[str, Tensor], dict[str, NDArray[Any]], NDArray[Any]]:
    """Through an open world without noise towards (6, 3).

    Policy, memory, the next reading, and where it got to.
    """
    policy, position = in_the_lane(), np.zeros(2)
    memory: Any = None
    for step in range(steps + 1):
        ahead = np.array([6.0, 3.0]) - position
        bearing = np.array([math.atan2(ahead[1], ahead[0])])
        reading = {"bearing": bearing, "range": np.array([20.0])}
        if step == steps:
            break
        if memory is not None:
            memory = policy.switch(memory, lane=lane)
        action, memory = policy.predict(reading, memory)
        position = position + 0.05 * action
    return policy, policy.switch(memory, lane=lane), reading, position


def test_a_fourth_goal_acts() -> None:
    """Outside the lane it pulls the robot in, alone and among the others."""
    policy, memory, reading, _ = drive(lane=False, steps=100)
    assert memory["p_tar"][1] > 0.5

    alone = policy.switch(memory, reach=False, avoid=False, lane=True)
    _, after = policy.predict(reading, alone)
    wish = after["a"] - memory["a"] * 2 / 7  # the low-pass keeps two sevenths
    assert wish[1] > 0.1 and abs(float(wish[0])) < 1e-9

    changes = []
    for lane in (True, False):
        _, after = policy.predict(reading, policy.switch(memory, lane=lane))
        changes.append(policy.explain(after).goals["lane"].predicted_change)
    assert changes[0] < changes[1] - 1e-3


def test_a_fourth_goal_keeps_the_robot_in_its_lane_on_the_way() -> None:
    heights = {lane: abs(drive(lane, 130)[3][1] - 3.0) for lane in (True, False)}
    assert heights[True] < 0.5 < heights[False]
