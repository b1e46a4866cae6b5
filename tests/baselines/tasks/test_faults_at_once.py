"""Faults at once: each does what it does alone, and what is told of it stays true."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from aicon_baselines.evaluation.config import configure
from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.tasks import load
from aicon_baselines.tasks.faults import disturbed

STEPS, COUNT = 60, 3
TASK = load("nav2d")
FORWARD = np.array([[0.1, 0.0]] * COUNT, np.float32)


def sensed(condition: str) -> dict[str, NDArray[Any]]:
    """What three agents read that drive slowly, without noise: ``(steps, rows)`` each."""
    env = TASK.make_env(COUNT, condition, 3 * STEPS, bearing_noise=0.0, range_noise=0.0)
    episodes = [TASK.episode(1000 + row) for row in range(COUNT)]
    observation, _ = env.reset(**TASK.reset_arguments(episodes))
    found = [observation]
    for _ in range(STEPS):
        observation, *_ = env.step(FORWARD)
        found.append(observation)
    return {key: np.array([one[key][:, 0] for one in found]) for key in observation}


def steps(times: NDArray[Any]) -> NDArray[np.int64]:
    return np.rint(times / TASK.time_step).astype(np.int64)


@pytest.mark.parametrize("late", ["late", "jitter", "late+jitter"])
def test_ages_count_the_time_that_has_passed_however_long_the_steps(late: str) -> None:
    plain, faulty = sensed("range"), sensed(f"{late}+uneven")
    lasting = steps(faulty["elapsed"])
    assert set(np.unique(lasting[1:])) == {1, 2, 3}

    now = lasting.cumsum(0) - 1
    then = (now - steps(faulty["age"]))[:20]
    expected = np.take_along_axis(plain["range"], then, axis=0)
    np.testing.assert_array_equal(faulty["range"][:20], expected)


def test_a_held_action_does_not_make_late_readings_prompt() -> None:
    ages = steps(sensed("late+held")["age"])
    assert (ages[4:] == 4).all()
    assert "age" not in sensed("held")


def test_how_long_a_step_took_is_told_at_once() -> None:
    np.testing.assert_array_equal(sensed("late+uneven")["elapsed"], sensed("uneven")["elapsed"])


def test_what_was_executed_is_told_at_once() -> None:
    """In half of the steps it is the action of that very step."""
    env = TASK.make_env(COUNT, "late+held", STEPS)
    env.reset(**TASK.reset_arguments([TASK.episode(1000 + row) for row in range(COUNT)]))
    is_own = []
    for step in range(STEPS):
        action = 0.001 * (step + 1) * np.sign(FORWARD)
        observation, *_ = env.step(action)
        is_own.append((observation["executed"] == action).all(-1))
    assert 0.3 < np.mean(is_own) < 0.7


def test_a_bias_is_added_to_what_comes_late() -> None:
    np.testing.assert_allclose(sensed("late+bias")["range"], sensed("late")["range"] + 0.05, 1e-5)


def test_readings_that_freeze_are_of_the_age_that_they_come_with() -> None:
    ages = steps(sensed("jitter+stuck")["age"])
    np.testing.assert_array_equal(ages, steps(sensed("jitter")["age"]))


def test_the_order_of_the_words_does_not_matter() -> None:
    one, other = sensed("outliers+late+held"), sensed("held+late+outliers")
    for key, readings in one.items():
        np.testing.assert_array_equal(readings, other[key])


def test_faults_at_once_draw_numbers_of_their_own() -> None:
    """Whether an action is held says nothing of whether a reading is an outlier."""
    env = TASK.make_env(COUNT, "outliers+held", STEPS)
    episodes = [TASK.episode(1000 + row) for row in range(COUNT)]
    env.reset(**TASK.reset_arguments(episodes))
    outer: Any = env
    inner: Any = disturbed(env, "outliers")
    assert outer._generators[0].uniform() != inner._generators[0].uniform()


def test_a_layer_that_is_not_there_is_an_error_by_name() -> None:
    with pytest.raises(ValueError, match="'gone'"):
        disturbed(TASK.make_env(1, "late+stuck", STEPS), "gone")


@pytest.mark.parametrize("name", ["nav2d", "pusht", "arm_push"])
def test_what_is_told_adds_up(name: str) -> None:
    task = load(name)
    late, jitter = (task.policy_options(one)["delay"] for one in ("late", "jitter"))
    assert task.policy_options("late+jitter")["delay"] == late + jitter
    assert set(task.policy_options("bias")) <= set(task.policy_options("late+bias"))


@pytest.mark.parametrize("name", ["nav2d", "pusht", "arm_push"])
def test_two_faults_are_a_condition(name: str) -> None:
    assert configure(load(name), conditions=["late+bias"]).conditions == ("late+bias",)


@pytest.mark.parametrize("wrong", ["late+late", "late+odd", "late+range", "late+"])
def test_what_is_no_pair_is_an_error_that_lists_the_faults(wrong: str) -> None:
    with pytest.raises(ComparisonError, match=r"unknown condition .*several at once of late, ji"):
        configure(TASK, conditions=[wrong])
