"""The task "arm_push"."""

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("aicon_envs.arm_push")

from aicon_baselines.agents import factory, names
from aicon_baselines.evaluation.rollout import rollout
from aicon_baselines.tasks import load
from aicon_baselines.tasks.arm_push import TASK


def test_the_task_is_found_by_name_and_has_the_presets_of_its_model() -> None:
    assert load("arm_push") is TASK
    assert names("arm_push")[0] == "aicon" and "steepest" in names("arm_push")


@pytest.mark.slow
def test_a_condition_names_another_arm() -> None:
    pytest.importorskip("trimesh")
    pytest.importorskip("pytorch_kinematics")
    policy = factory("arm_push", "aicon")("ur5_true_pose")
    task = replace(load("arm_push"), horizon=10, chunk_size=2)
    outcome = rollout(policy, task, "ur5_true_pose", task.chunk(0, 0), [0, 1])
    assert (outcome.steps == 10).all() and (outcome.path_length > 0).all()


def test_a_chunk_runs_as_one_batch_with_the_true_pose() -> None:
    policy = factory("arm_push", "aicon", **{"law.iterations": 2})("true_pose")
    task = replace(TASK, horizon=8, chunk_size=3)
    outcome = rollout(policy, task, "true_pose", task.chunk(0, 0), [0, 2])
    assert (outcome.steps == 8).all() and not outcome.success.any()
    assert (outcome.path_length > 0).all()


def test_an_episode_that_ended_stands_still_while_the_others_go_on() -> None:
    env = TASK.make_env(2, "true_pose", 3)
    env.reset(seed=[0, 1])
    steps = [env.step(np.zeros((2, 7))) for _ in range(5)]
    assert steps[2][3].all() and steps[4][3].all()
    np.testing.assert_array_equal(steps[2][0]["q"], steps[4][0]["q"])
    env.close()


def test_the_policy_is_told_object_body_and_delay_but_neither_mass_nor_friction() -> None:
    usual, long = TASK.policy_options("true_pose"), TASK.policy_options("object_L")
    assert usual["corners"] != long["corners"] and len(long["corners"]) == 6
    assert usual["robot"].shape.capsules == long["robot"].shape.capsules
    assert usual["camera.delay"] == 0 and TASK.policy_options("image_delay")["camera.delay"] == 10
    assert set(usual) == {"robot", "corners", "sensing", "camera.delay"}
