import numpy as np
import pytest

pytest.importorskip("aicon_envs.panda_push")

import compare
from aicon_baselines.agents.registry import compiled, factory, names
from aicon_baselines.evaluation.rollout import rollout
from aicon_baselines.tasks import load as load_task
from aicon_baselines.tasks.panda_push import TASK
from aicon_baselines.tasks.panda_push_numbers import (
    EpisodeNumbers,
    count_turns,
    in_words,
    load,
    save,
    watch,
)
from aicon_torch import make_policy


def test_the_task_is_found_by_name_and_has_the_presets_of_its_model():
    assert load_task("panda_push") is TASK
    assert names("panda_push")[0] == "aicon" and "steepest" in names("panda_push")


def test_comparisons_compile_its_policies():
    arguments = compare._parser().parse_args(
        ["--task", "panda_push", "--policies", "steepest", "--out", "runs"]
    )
    (policy,) = compare._policies(TASK, arguments).items()
    assert (
        policy[0] == "steepest"
        and policy[1].func is compiled(factory("panda_push", "steepest")).func
    )


def test_a_chunk_runs_as_one_batch_with_the_true_pose():
    policy = factory("panda_push", "aicon")("true_pose")
    task = TASK.__class__(**{**TASK.__dict__, "horizon": 20, "chunk_size": 3})
    outcome = rollout(policy, task, "true_pose", task.chunk(0, 0), [0, 2])
    assert (outcome.steps == 20).all() and not outcome.success.any()
    assert (outcome.path_length > 0).all()


def test_an_episode_that_ended_stands_still_while_the_others_go_on():
    env = TASK.make_env(2, "true_pose", 3)
    env.reset(seed=[0, 1])
    steps = [env.step(np.zeros((2, 7))) for _ in range(5)]
    assert steps[2][3].all() and steps[4][3].all()
    np.testing.assert_array_equal(steps[2][0]["q"], steps[4][0]["q"])
    env.close()


def test_the_policy_is_told_the_object_and_its_body_but_neither_mass_nor_friction():
    usual, long = TASK.policy_options("true_pose"), TASK.policy_options("object_L")
    assert usual["corners"] != long["corners"] and len(long["corners"]) == 6
    assert usual["robot"] == long["robot"]
    assert set(usual) == {"robot", "corners", "sensing"}


def test_the_numbers_of_episodes_are_a_row_each(tmp_path):
    policy = make_policy("panda_push", **TASK.policy_options("true_pose"))
    seen = []
    episodes = TASK.chunk(0, 0)[4:7]
    numbers = watch(policy, "true_pose", episodes, 30, seen.append, [4, 5])
    assert [row.seed for row in numbers] == [4, 5] and sorted(seen) == numbers
    assert all(
        row.collisions == 0 and row.limit_margin > 0 and row.self_distance > 0 for row in numbers
    )
    save(numbers, tmp_path / "numbers.csv")
    header, *rows = (tmp_path / "numbers.csv").read_text().splitlines()
    assert header.split(",") == list(EpisodeNumbers._fields) and len(rows) == 2
    again = load(tmp_path / "numbers.csv")
    assert [row.to_fields() for row in again] == [row.to_fields() for row in numbers]
    assert [type(value) for value in again[0]] == [type(value) for value in numbers[0]]
    assert in_words(numbers).startswith("0/2 solved")


def test_episodes_are_those_of_a_comparison():
    horizon, episodes = 40, TASK.chunk(0, 0)[:2]
    policy = make_policy("panda_push", **TASK.policy_options("true_pose"))
    task = TASK.__class__(**{**TASK.__dict__, "horizon": horizon})
    outcome = rollout(policy, task, "true_pose", episodes, [0, 1])
    numbers = watch(policy, "true_pose", episodes, horizon)
    np.testing.assert_allclose(
        [row.distance for row in numbers], 1e3 * outcome.distance, rtol=1e-12
    )
    np.testing.assert_allclose(
        [row.angle for row in numbers], np.degrees(outcome.measures["angle"]), rtol=1e-12
    )
    for name in ("limit_margin", "self_distance"):
        np.testing.assert_allclose(
            [getattr(row, name) for row in numbers], outcome.measures[name], atol=1e-6
        )


def test_turns_are_counted_beyond_an_amplitude():
    time = np.linspace(0, 10, 1000)
    assert count_turns(np.sin(2 * np.pi * time), 0.3) == 20
    assert count_turns(0.1 * np.sin(2 * np.pi * time), 0.3) == 0
    assert count_turns(time, 0.3) == 0
