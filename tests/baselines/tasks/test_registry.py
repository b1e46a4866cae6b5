"""Tasks by name, and what every task promises."""

from dataclasses import replace
from importlib.util import find_spec

import numpy as np
import pytest

from aicon_baselines import tasks
from aicon_baselines.agents import factory
from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.evaluation.rollout import rollout
from aicon_baselines.tasks import registry

TASKS = [
    "nav2d",
    pytest.param(
        "pusht", marks=pytest.mark.skipif(find_spec("pymunk") is None, reason="needs pymunk")
    ),
]


def test_unknown_names_list_the_valid_ones() -> None:
    with pytest.raises(ComparisonError, match="valid tasks: nav2d, pusht, arm_push, reach"):
        tasks.load("chess")
    assert tasks.names() == ("nav2d", "pusht", "arm_push", "reach")


@pytest.mark.parametrize(
    ("task", "extra"),
    [("pusht", "pusht"), ("arm_push", "panda"), ("reach", "reach")],
)
def test_a_task_says_what_it_needs(task: str, extra: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(registry._MODULES, task, "no_such_module")
    message = f"'no_such_module'; the task '{task}' needs: pip install 'aicon-torch.{extra}.'"
    with pytest.raises(ComparisonError, match=message):
        tasks.load(task)


@pytest.mark.parametrize("name", TASKS)
def test_every_condition_can_be_run(name: str) -> None:
    task = replace(tasks.load(name), chunk_size=2, horizon=2)
    assert set(task.noiseless) <= set(task.conditions)

    for condition in task.conditions:
        if condition == "upstream":
            pytest.importorskip("gym_pusht")
        policy = factory(name, "aicon", **{"law.iterations": 2})(condition)
        episodes = task.chunk(0, repeat=0)
        first = rollout(policy, task, condition, episodes, range(2))
        again = rollout(policy, task, condition, episodes, range(2))

        assert (first.steps == 2).all() and (first.path_length > 0).all(), condition
        np.testing.assert_array_equal(first.path_length, again.path_length)


@pytest.mark.parametrize("name", TASKS)
def test_a_task_leaves_ended_episodes_alone(name: str) -> None:
    task = tasks.load(name)
    env = task.make_env(2, task.conditions[0], 3)
    env.reset(**task.reset_arguments(task.chunk(0, repeat=0)[:2]))
    actions = 0.5 * np.ones((2, 2), np.float32)

    for _ in range(3):
        *_, truncated, info = env.step(actions)
    assert truncated.all()

    *_, truncated, later = env.step(actions)
    assert truncated.all()
    np.testing.assert_array_equal(info["position"], later["position"])
    env.close()


@pytest.mark.parametrize("name", TASKS)
def test_an_environment_can_be_seen(name: str) -> None:
    task = tasks.load(name)
    env = task.make_env(1, task.conditions[0], 3, render_mode="rgb_array")
    env.reset(**task.reset_arguments([task.episode(0)]))
    (picture,) = env.render() or ()
    assert picture.ndim == 3 and picture.shape[-1] == 3
    env.close()
