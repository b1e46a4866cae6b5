"""The scene of OGBench, where its package is installed."""

import sys
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

import pytest

WORLDS = Path(__file__).parents[2] / "examples" / "worlds"


@pytest.mark.slow
@pytest.mark.skipif(not find_spec("ogbench"), reason="needs: make worlds")
@pytest.mark.filterwarnings("ignore")  # of one package about another
def test_a_drawer_is_unlocked_opened_filled_and_shut(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "path", [str(WORLDS), *sys.path])
    world = import_module("ogbench_scene")

    policy = world.build(world.Options(**world.TASK.policy_options("task4"))).compile()
    env = world.TASK.make_env(1, "task4", horizon=300)
    (observation, _), memory, done, opened = env.reset(seed=1001), None, False, 0.0
    while not done:
        action, memory = policy.predict(observation, memory)
        observation, _, terminated, truncated, info = env.step(action)
        done = (terminated | truncated).all()
        opened = max(opened, observation["z_way_drawer"].item())
    env.close()
    assert opened > 0.15  # m
    assert info["is_success"].all()
