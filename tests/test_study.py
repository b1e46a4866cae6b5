"""The comparison on a few maps nobody reports: slow, so run by `pytest -m slow`."""

import pytest

from aicon_baselines.nav2d import TASK
from aicon_baselines.policies import make
from aicon_baselines.rollout import rollout
from aicon_baselines.task import Episode

EPISODES = [Episode(seed, 0, TASK.maps[seed % len(TASK.maps)]) for seed in range(2040, 2074)]


@pytest.mark.slow
def test_aicon_escapes_where_the_others_stay() -> None:
    seeds = [episode.seed for episode in EPISODES]
    success = {
        name: float(rollout(make("nav2d", name), TASK, "range", EPISODES, seeds).success.mean())
        for name in ("aicon", "paper_literal", "steepest", "potential_field")
    }
    assert success["aicon"] >= 0.97
    assert success["aicon"] > success["paper_literal"] > max(success["steepest"], success["potential_field"])
