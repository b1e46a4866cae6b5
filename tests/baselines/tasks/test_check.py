"""The check of a task: every task that is shipped passes, and what is broken is said."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, VectorEnv, VectorWrapper

from aicon_baselines import tasks
from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.evaluation.task import Task
from aicon_envs.nav2d import Nav2DVectorEnv
from aicon_torch.models import nav2d

EXTRAS = {"pusht": "pymunk", "arm_push": "trimesh", "reach": "trimesh"}
QUICK = {"nav2d": ["range", "late"], "pusht": ["object_L", "late"]}

REACH = (
    "panda_pose_home",
    "panda_position_random_fast",
    "ur5_pose_random_moving_ball",
    "xarm7_position_home_ball",
    "so101_axis_random",
)
"""Conditions of reaching are a product: each robot, goal, start and surprise once."""


@pytest.mark.parametrize("name", QUICK)
def test_a_task_of_the_plane_keeps_what_a_task_promises(name: str) -> None:
    pytest.importorskip(EXTRAS.get(name, "numpy"))
    tasks.check_task(tasks.load(name), QUICK[name])


@pytest.mark.slow
@pytest.mark.parametrize("name", tasks.names())
def test_every_task_keeps_what_a_task_promises_in_its_conditions(name: str) -> None:
    pytest.importorskip(EXTRAS.get(name, "numpy"))
    task = tasks.load(name)

    # What needs a renderer or another package has tests of its own.
    left_out = {"upstream", "camera"}
    conditions = [condition for condition in task.conditions if condition not in left_out]
    if name == "arm_push":
        conditions = [condition for condition in conditions if "pose" in condition]
    if name == "reach":
        conditions = list(REACH)
    tasks.check_task(task, conditions)


class Changed(VectorWrapper):
    """Navigation with something that is not as promised."""

    def __init__(self, env: VectorEnv[Any, Any, Any], change: Callable[[dict[str, Any]], Any]):
        super().__init__(env)
        self._change = change

    def reset(self, **arguments: Any) -> Any:
        observation, info = self.env.reset(**arguments)
        self._change(info)
        return observation, info

    def step(self, actions: Any) -> Any:
        *result, info = self.env.step(actions)
        self._change(info)
        return (*result, info)


def with_info(change: Callable[[dict[str, Any]], Any]) -> Task:
    """Navigation whose info is changed."""
    task = tasks.load("nav2d")

    def make_env(*arguments: Any, **options: Any) -> VectorEnv[Any, Any, Any]:
        return Changed(task.make_env(*arguments, **options), change)

    return replace(task, make_env=make_env)


def wander(info: dict[str, Any]) -> None:
    """Be somewhere else every time."""
    info["position"] = info["position"] + np.random.default_rng().normal(size=2)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda info: info.pop("distance"), "info has no 'distance'; it has: .*position"),
        (lambda info: info.update(distance=np.zeros(3)), r"info\['distance'\] has shape \(3,\)"),
        (lambda info: info.update(distance=np.full(2, np.nan)), "it is finite numbers"),
        (lambda info: info.update(position=np.zeros(2)), r"it is \(2, 2\) for 2 episodes"),
        (wander, "an episode that has ended moves; disable autoreset"),
    ],
)
def test_what_an_environment_does_not_tell_is_said(
    change: Callable[[dict[str, Any]], Any], message: str
) -> None:
    with pytest.raises(ComparisonError, match=f"task 'nav2d', condition 'range': .*{message}"):
        tasks.check_task(with_info(change), ["range"], policy="")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"horizon": 0}, "horizon must be more than 0, not 0"),
        ({"maps": ()}, "maps must be more than 0"),
        (
            {"noiseless": ("dark",)},
            "noiseless names 'dark', which is none of its conditions",
        ),
        ({"milestones": (20_000,)}, "must be within the horizon"),
        ({"presets": ("aicon", "clever")}, "has no preset 'clever'; it has: aicon, paper_literal"),
        ({"model": ""}, "has presets and no model: `model=__name__` where"),
    ],
)
def test_what_a_task_declares_in_vain_is_said(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ComparisonError, match=message):
        tasks.check_task(replace(tasks.load("nav2d"), **changes))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"noiseless": ("range",)}, "it is declared noiseless, and its repeats differ"),
        (
            {"reset_arguments": lambda episodes: {"seed": None}},
            "the same seeds and actions give another step 0.*depends on the seed",
        ),
        (
            {"policy_options": lambda condition: {"sight": "far"}},
            "the policy 'aicon' cannot be built: .*no option 'sight'.*`policy_options` name",
        ),
    ],
)
def test_episodes_that_are_not_what_they_should_be_are_said(
    changes: dict[str, Any], message: str
) -> None:
    with pytest.raises(ComparisonError, match=message):
        tasks.check_task(replace(tasks.load("nav2d"), **changes), ["range"])


def test_a_preset_that_cannot_be_built_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(nav2d, "PRESETS", {**nav2d.PRESETS, "steepest": {"resolution.explore": 1}})
    with pytest.raises(ComparisonError, match="the policy 'steepest' cannot be built: .*'explore'"):
        tasks.check_task(tasks.load("nav2d"), ["range"])


def test_commands_beyond_the_action_space_are_said() -> None:
    fast = replace(tasks.load("nav2d"), policy_options=lambda condition: {"max_speed": 5.0})
    with pytest.raises(ComparisonError, match="beyond the action space; an actuator's `command`"):
        tasks.check_task(fast, ["range"])


def test_episodes_without_an_end_are_said() -> None:
    def make_env(count: int, condition: str, horizon: int, **options: Any) -> Nav2DVectorEnv:
        return Nav2DVectorEnv(count, autoreset_mode=AutoresetMode.DISABLED, **options)

    task = replace(tasks.load("nav2d"), make_env=make_env)
    with pytest.raises(ComparisonError, match="episodes go on after the horizon of 4 steps"):
        tasks.check_task(task, ["range"], policy="")
