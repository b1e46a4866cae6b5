"""The task "reach"."""

import re
from collections.abc import Iterator
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("mujoco")
pytest.importorskip("trimesh")
pytest.importorskip("pytorch_kinematics")

from aicon_baselines.agents import factory, names
from aicon_baselines.evaluation.comparison import compare
from aicon_baselines.evaluation.config import configure
from aicon_baselines.evaluation.rollout import rollout
from aicon_baselines.evaluation.run_folder import RunFolder
from aicon_baselines.tasks import load
from aicon_baselines.tasks.reach import TASK

MEASURES = ("angle", "limit_margin", "self_gap", "ball_gap")


def test_the_task_is_found_by_name_and_has_presets_and_opponents() -> None:
    assert load("reach") is TASK
    assert names("reach")[0] == "aicon"
    assert {"steepest", "potential_field", "damped_least_squares", "mink"} <= set(names("reach"))


def test_an_opponent_that_goes_to_places_is_the_same_with_them() -> None:
    alone: Any = factory("reach", "damped_least_squares")("ur5_pose_home")
    escaping = factory("reach", "damped_least_squares_places")("ur5_pose_home")
    assert escaping == replace(alone, places=True) != alone


def test_the_patterns_of_a_shell_are_the_conditions() -> None:
    assert {name for pattern in TASK.patterns for name in expanded(pattern)} == {*TASK.conditions}


def expanded(pattern: str) -> Iterator[str]:
    """What a shell makes of "{a,b}_{c,d}"."""
    parts = re.split(r"\{(.*?)\}", pattern)  # outside and inside of braces, in turns
    words = [[part] if number % 2 == 0 else part.split(",") for number, part in enumerate(parts)]
    return map("".join, product(*words))


def test_conditions_are_robots_targets_starts_and_what_else_is_different() -> None:
    for name in ("panda_pose_home", "ur5_position_random_fast", "xarm7_pose_home_moving_ball"):
        assert name in TASK.conditions
    assert "so101_axis_home" in TASK.conditions and TASK.noiseless == TASK.conditions


def test_a_chunk_runs_as_one_batch_and_gives_rows_with_violations(tmp_path: Path) -> None:
    task = replace(TASK, chunk_size=2)
    config = configure(task, seed=1000, episodes=2, conditions=["ur5_position_home"], horizon=15)
    policies = {"damped_least_squares": factory("reach", "damped_least_squares")}
    with RunFolder.open(tmp_path, config) as folder:
        compare(task, policies, folder)
        rows = folder.rows()

    assert [row.seed for row in rows] == [1000, 1001]
    for row in rows:
        assert set(row.measures) == set(MEASURES)
        assert row.path_length > 0.0 and row.measures["limit_margin"] > 0.0


def test_our_policy_runs_the_same_episodes_again() -> None:
    policy = factory("reach", "aicon")("ur5_pose_home")
    task = replace(TASK, horizon=5, chunk_size=2)
    first, again = (rollout(policy, task, "ur5_pose_home", task.chunk(0, 0), [0]) for _ in range(2))
    assert (first.path_length > 0.0).all() and not first.collision.any()
    np.testing.assert_array_equal(first.path_length, again.path_length)


def test_a_policy_is_told_its_robot_and_of_balls_where_there_are_some() -> None:
    usual = TASK.policy_options("panda_pose_home")
    assert usual["orientation"] == "full" and usual["speed"] == 1.5 and usual["dt"] == 0.02
    assert usual["tip"] == "panda_hand_tcp" and usual["robot"].endswith("panda.urdf")
    assert "balls" not in usual and TASK.policy_options("panda_pose_home_ball")["balls"] == 1
    assert TASK.policy_options("panda_position_home_fast")["speed"] == 3.0


def test_an_episode_that_ended_stands_still_while_the_others_go_on() -> None:
    env = TASK.make_env(2, "ur5_pose_home", 3)
    env.reset(seed=[0, 1])
    steps = [env.step(np.zeros((2, 6))) for _ in range(5)]
    assert steps[2][3].all() and steps[4][3].all()
    np.testing.assert_array_equal(steps[2][0]["q"], steps[4][0]["q"])
    env.close()
