"""Tasks by name: ours, those of other packages, and your own."""

import sys
from functools import partial
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest
from _inputs.needs import NEEDS_PYMUNK

from aicon_baselines import agents, tasks
from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.tasks import registry

TASKS = ["nav2d", pytest.param("pusht", marks=NEEDS_PYMUNK)]


def test_unknown_names_list_the_valid_ones() -> None:
    with pytest.raises(ComparisonError, match="valid tasks: nav2d, pusht, arm_push, reach"):
        tasks.load("chess")
    assert tasks.names() == ("nav2d", "pusht", "arm_push", "reach")


def test_a_task_goes_by_a_name_that_it_had_before() -> None:
    pytest.importorskip("mujoco")
    assert tasks.load("panda_push") == tasks.load("arm_push")
    assert agents.names("panda_push") == agents.names("arm_push")


OWN = """
from dataclasses import replace
from aicon_baselines.tasks.nav2d import TASK

OWN = replace(TASK, name="mine", agents={})
"""


def test_a_task_of_your_own_is_named_by_its_module(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "task_of_mine.py").write_text(OWN)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))

    task = tasks.load("task_of_mine:OWN")
    assert task.name == "task_of_mine:OWN" and not task.agents
    assert agents.factory(task.name, "steepest")("range") is not None

    for name in ("task_of_mine:OTHER", "nowhere:OWN"):
        with pytest.raises(ComparisonError, match=f"'{name}': .*(OTHER|nowhere)"):
            tasks.load(name)
    for name in ("./task_of_mine.py:OWN", "task_of_mine.py:OWN", ":OWN"):
        with pytest.raises(ComparisonError, match=f"'{name}': MODULE is a name such as my_module"):
            tasks.load(name)
    with pytest.raises(ComparisonError, match="'nowhere.mine:OWN': No module named 'nowhere'"):
        tasks.load("nowhere.mine:OWN")
    with pytest.raises(ComparisonError, match="'math:pi' is a float; expected a Task"):
        tasks.load("math:pi")


def test_another_package_can_register_a_task(monkeypatch: pytest.MonkeyPatch) -> None:
    entry = EntryPoint("theirs", "aicon_baselines.tasks.nav2d:TASK", "aicon.tasks")
    monkeypatch.setattr(registry, "entry_points", lambda group: [entry])
    registry._sources.cache_clear()
    try:
        assert tasks.names() == ("nav2d", "pusht", "arm_push", "reach", "theirs")
        assert tasks.load("theirs").name == "theirs"
    finally:
        monkeypatch.undo()
        registry._sources.cache_clear()


@pytest.mark.parametrize("name", TASKS)
def test_an_environment_can_be_seen(name: str) -> None:
    task = tasks.load(name)
    env = task.make_env(1, task.conditions[0], 3, render_mode="rgb_array")
    env.reset(**task.reset_arguments([task.episode(0)]))
    (picture,) = env.render() or ()
    assert picture.ndim == 3 and picture.shape[-1] == 3
    env.close()


@pytest.mark.parametrize(
    ("name", "package"), [("pusht", "pymunk"), ("arm_push", "mujoco"), ("reach", "mujoco")]
)
def test_an_unknown_condition_lists_the_valid_ones(name: str, package: str) -> None:
    pytest.importorskip(package)
    task = tasks.load(name)
    message = f"unknown condition 'odd'; valid conditions: {task.conditions[0]}, "
    for ask in (partial(task.make_env, 1, "odd", 3), partial(task.policy_options, "odd")):
        with pytest.raises(ComparisonError, match=message):
            ask()
