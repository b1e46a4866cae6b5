"""A robot in a crowd of people, where the package that moves them is installed."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from _worlds import episodes


@pytest.fixture
def crowd(world_of: Callable[[str], Any]) -> Any:
    """The world."""
    pytest.importorskip("pyrvo", reason="needs: make worlds")
    return world_of("crowd")


def test_orca_and_the_graph_read_the_same(crowd: Any) -> None:
    env = crowd.TASK.make_env(2, "circle10", horizon=2)
    policy = crowd.build(crowd.Options(**crowd.TASK.policy_options("circle10")))
    observation, _ = env.reset(seed=[1000, 1001])
    assert set(observation) == set(policy.model.sensors) and len(policy.model.paths()) == 2

    for steered in (policy, crowd.Orca()):
        action, _ = steered.predict(observation)
        assert np.asarray(action).shape == (2, 2)
        env.step(np.asarray(action))
    env.close()


@pytest.mark.slow
def test_among_people_who_do_not_see_it_a_robot_touches_nobody_and_arrives(
    crowd: Any,
) -> None:
    *_, (_, info) = episodes(crowd, "circle5_blind", [1000, 1027])
    assert info["is_success"].all() and not info["collision"].any()


def test_people_make_way_for_a_robot_that_they_see(crowd: Any) -> None:
    nearest = {}

    for is_seen in (True, False):
        env, ended, gaps = crowd.Crowd("circle20", is_seen), False, []
        env.reset(seed=1000)
        while not ended and len(gaps) < 100:
            _, _, ended, _, info = env.step(np.array([0.0, 1.0]))
            gaps.append(np.linalg.norm(env.people - env.robot, axis=1).min() - 2 * crowd.RADIUS)
        nearest[is_seen] = min(gaps)
        assert ended == (info["collision"] or info["is_success"])
    assert nearest[False] < 0 < nearest[True]
