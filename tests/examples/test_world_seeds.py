"""An episode in other people's worlds begins as its seed says, and goes on alike."""

from collections.abc import Callable
from importlib.util import find_spec
from typing import Any

import numpy as np
import pytest

WORLDS = (
    "so101_pick_place",
    "so101_pick_cube",
    "so101_by_joints",
    "so101_in_the_way",
    "ogbench_mazes",
    "ogbench_scene",
    "pointmaze",
    "fetch",
    "meta_world",
    "meta_world_puck",
    "crowd",
)


@pytest.mark.slow
@pytest.mark.skipif(not find_spec("ogbench"), reason="needs: make worlds")
@pytest.mark.filterwarnings("ignore")  # of one package about another
@pytest.mark.parametrize("name", WORLDS)
def test_a_seed_gives_the_same_episode(name: str, world_of: Callable[[str], Any]) -> None:
    task = world_of(name).TASK
    first, again = (seen_of(task) for _ in range(2))
    for before, after in zip(first, again, strict=True):
        for reading, value in before.items():
            np.testing.assert_array_equal(value, after[reading], err_msg=reading)


def seen_of(task: Any) -> list[Any]:
    """What is seen in ten steps of a new world, whose actions are drawn."""
    env = task.make_env(1, task.conditions[0], task.horizon)
    seen = [env.reset(seed=[1003])[0]]
    env.action_space.seed(0)
    for _ in range(10):
        seen.append(env.step(env.action_space.sample())[0])
    env.close()
    return seen
