"""The numbers that say how the arm pushed."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("aicon_envs.arm_push")

from aicon_baselines.agents import factory
from aicon_baselines.evaluation.rollout import rollout
from aicon_baselines.tasks.arm_push import TASK
from aicon_baselines.tasks.arm_push_numbers import (
    EpisodeNumbers,
    conflicts_of,
    in_words,
    load,
    save,
)
from aicon_baselines.tasks.arm_push_recording import count_turns, watch


def test_the_numbers_of_episodes_are_a_row_each(tmp_path: Path) -> None:
    policy = factory("arm_push", "aicon", **{"law.iterations": 1})("true_pose")
    seen: list[EpisodeNumbers] = []
    numbers = watch(policy, "true_pose", TASK.chunk(0, 0)[4:7], 10, seen.append, [4, 5])

    assert [row.seed for row in numbers] == [4, 5] and sorted(seen) == numbers
    for row in numbers:
        assert row.collisions == 0 and row.limit_margin > 0 and row.self_distance > 0
    assert in_words(numbers).startswith("0/2 solved")

    path = tmp_path / "numbers.csv"
    save(numbers, path)
    header, *lines = path.read_text().splitlines()
    assert header.split(",") == list(EpisodeNumbers._fields) and len(lines) == 2

    again = load(path)
    assert [row.to_fields() for row in again] == [row.to_fields() for row in numbers]
    assert [type(value) for value in again[0]] == [type(value) for value in numbers[0]]


def test_episodes_are_those_of_a_comparison() -> None:
    horizon, episodes = 12, TASK.chunk(0, 0)[:2]
    policy = factory("arm_push", "aicon", **{"law.iterations": 1})("true_pose")
    task = replace(TASK, horizon=horizon)
    outcome = rollout(policy, task, "true_pose", episodes, [0, 1])
    numbers = watch(policy, "true_pose", episodes, horizon)

    distances, angles = 1e3 * outcome.distance, np.degrees(outcome.measures["angle"])
    np.testing.assert_allclose([row.distance for row in numbers], distances, rtol=1e-12)
    np.testing.assert_allclose([row.angle for row in numbers], angles, rtol=1e-12)
    for name in ("limit_margin", "self_distance"):
        taken = [getattr(row, name) for row in numbers]
        np.testing.assert_allclose(taken, outcome.measures[name], atol=1e-6)


def test_turns_are_counted_beyond_an_amplitude() -> None:
    time = np.linspace(0, 10, 1000)
    assert count_turns(np.sin(2 * np.pi * time), 0.3) == 20
    assert count_turns(0.1 * np.sin(2 * np.pi * time), 0.3) == 0
    assert count_turns(time, 0.3) == 0


def test_conflicts_are_counted_over_all_episodes() -> None:
    numbers = []
    for conflicts in ("x_ee:push/heights=2 x_joints:push/limits=1", "", "x_ee:push/heights=3"):
        fields = [conflicts if name == "conflicts" else "0" for name in EpisodeNumbers._fields]
        numbers.append(EpisodeNumbers.from_fields(fields))
    assert conflicts_of(numbers) == {"x_ee:push/heights": 5, "x_joints:push/limits": 1}
