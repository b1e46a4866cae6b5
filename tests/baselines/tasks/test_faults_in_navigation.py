"""A short version of the table of faults: nobody collides, whatever happens to the readings."""

import dataclasses

import pytest
from _inputs.shipped import quick

from aicon_baselines.agents.registry import make
from aicon_baselines.evaluation.rollout import rollout
from aicon_baselines.tasks import load
from aicon_baselines.tasks.faults import FAULTS

COUNT, STEPS = 17, 240
"""An episode of each class of maps, long enough for every fault to begin."""

PAIRS = ("late+bias", "held+uneven", "held+bias", "uneven+bias", "stuck+outliers")
"""Faults that make each other worse."""


@pytest.mark.slow
@pytest.mark.parametrize("fault", (*FAULTS, *PAIRS))
def test_nobody_collides_and_nobody_is_stuck_at_once(fault: str) -> None:
    task = dataclasses.replace(load("nav2d"), horizon=STEPS)
    episodes = [task.episode(seed) for seed in range(1000, 1000 + COUNT)]
    seeds = [episode.seed for episode in episodes]

    policy = quick(make("nav2d", "aicon", fault))
    outcome = rollout(policy, task, fault, episodes, seeds)
    assert not outcome.collision.any()
    assert (outcome.path_length > 0.3).all()
