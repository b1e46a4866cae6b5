"""Ablations: each builds, acts, and differs from ours and from every other."""

import importlib

import pytest
from _asserts import rollout
from _inputs import drifting, lean
from _inputs.pushing import wandering

from aicon_baselines import agents
from aicon_torch.models import presets, replace_options

TASKS = ("nav2d", "pusht")


EVERY = [(task, name) for task in TASKS for name in agents.ablations(task)]


@pytest.mark.parametrize(("task", "name"), EVERY)
def test_every_ablation_builds_and_acts(task: str, name: str) -> None:
    policy = lean(task, **agents.ablations(task)[name])
    observations = drifting(3, (2,)) if task == "nav2d" else wandering(3, 2)
    for memory in rollout(policy, observations):
        assert all(value.isfinite().all() for value in memory.values())


@pytest.mark.parametrize("task", TASKS)
def test_every_ablation_is_another_than_ours_and_than_the_others(task: str) -> None:
    ours = importlib.import_module(f"aicon_torch.models.{task}").Options()
    settings = [ours]
    for changes in agents.ablations(task).values():
        setting = replace_options(ours, changes)
        assert setting not in settings
        settings.append(setting)


@pytest.mark.parametrize("task", TASKS)
def test_no_ablation_has_the_name_of_a_preset(task: str) -> None:
    assert not set(agents.ablations(task)) & set(presets(task))
