"""Policies by task and name."""

import pickle
from importlib.util import find_spec
from itertools import cycle

import numpy as np
import pytest
from _inputs.needs import NEEDS_PYMUNK

from aicon_baselines import agents, tasks
from aicon_baselines.agents.registry import AGGREGATIONS
from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.named import find
from aicon_baselines.resolutions import PCGrad
from aicon_torch import Policy, presets

SLOW = pytest.mark.slow
TASKS = ["nav2d", pytest.param("pusht", marks=NEEDS_PYMUNK)]


@pytest.mark.parametrize("task", TASKS)
def test_policies_of_a_task_are_presets_ablations_and_opponents(task: str) -> None:
    assert tasks.load(task).presets == presets(task)
    expected = (*presets(task), *agents.ablations(task), *agents.opponents(task))
    assert agents.names(task) == expected
    assert expected[0] == "aicon" and "without_exploration" in expected
    assert len(set(expected)) == len(expected)


@pytest.mark.parametrize("task", ["nav2d", pytest.param("pusht", marks=[NEEDS_PYMUNK, SLOW])])
def test_every_policy_can_be_built_and_steps(task: str) -> None:
    content = tasks.load(task)
    episodes = content.chunk(0, repeat=0)[:2]

    for name, condition in zip(_installed(task), cycle(content.conditions[:2]), strict=False):
        policy = agents.make(task, name, condition)
        if name in agents.ablations(task):  # they step in tests/baselines/ablations
            continue

        env = content.make_env(2, condition, 5, **getattr(policy, "env_options", {}))
        observation, _ = env.reset(**content.reset_arguments(episodes))

        action, state = policy.predict(observation, episode_start=np.ones(2, np.bool_))
        assert action.shape == (2, 2) and np.isfinite(action).all() and state is not None
        env.close()


def _installed(task: str) -> list[str]:
    """The policies of a task but for those that need what is not installed."""
    missing = {
        name
        for name, source in AGGREGATIONS.items()
        if any(find_spec(module) is None for module in find(source).modules)
    }
    return [name for name in agents.names(task) if name not in missing]


def test_an_aggregation_takes_the_place_of_our_resolution(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(PCGrad, "modules", ())  # it is not asked to resolve anything
    policy, ours = agents.make("nav2d", "pcgrad"), agents.make("nav2d", "aicon")
    assert isinstance(policy, Policy) and isinstance(ours, Policy)
    assert policy.resolution == PCGrad() and policy.law == ours.law


def test_an_opponent_that_needs_more_says_so_before_anything_runs(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(PCGrad, "modules", ("no_such_module",))
    with pytest.raises(ComparisonError, match=r"pip install 'aicon-torch\[peers\]'"):
        agents.factory("nav2d", "pcgrad")


def test_an_ablation_is_ours_without_one_part() -> None:
    ours, without = agents.make("nav2d", "aicon"), agents.make("nav2d", "without_exploration")
    assert isinstance(ours, Policy) and isinstance(without, Policy)
    assert ours.resolution.exploration is not None and without.resolution.exploration is None
    assert without.law == ours.law


def test_options_override_those_of_the_name_and_of_the_condition() -> None:
    options = {"law.step": 0.5, "sensing": "range_bearing", "max_speed": 0.3}
    policy = agents.factory("nav2d", "without_softmax", **options)("range")
    assert isinstance(policy, Policy)
    assert policy.resolution.temperature is None and policy.law.step == 0.5
    assert policy.model.actuators["a"].limit == 0.3
    assert "z_dir" in policy.model.sensors


def test_what_builds_a_policy_can_be_sent_to_a_worker() -> None:
    build = agents.compiled(agents.factory("nav2d", "steepest", max_speed=0.3))
    assert pickle.loads(pickle.dumps(build)) == build


def test_unknown_names_list_the_valid_ones() -> None:
    for build in (agents.make, agents.factory):
        message = "unknown policy 'oracle' for task 'nav2d'; valid policies: aicon, paper.*without_"
        with pytest.raises(ComparisonError, match=message):
            build("nav2d", "oracle")
    with pytest.raises(ComparisonError, match="valid tasks: nav2d, pusht"):
        agents.names("chess")
