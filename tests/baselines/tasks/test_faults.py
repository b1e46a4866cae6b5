"""Faults change what is read or executed, and nothing else; the seed tells which."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from aicon_baselines.tasks import load
from aicon_baselines.tasks.faults import FAULTS

STEPS, COUNT = 260, 3
TASK = load("nav2d")
FORWARD = np.array([[0.1, 0.0]] * COUNT, np.float32)

Observations = list[dict[str, NDArray[Any]]]


def sensed(condition: str, seed: int = 1000) -> Observations:
    """What three agents read that drive slowly through an empty map, without noise."""
    env = TASK.make_env(COUNT, condition, STEPS + 1, bearing_noise=0.0, range_noise=0.0)
    episodes = [TASK.episode(seed + row) for row in range(COUNT)]
    observation, _ = env.reset(**TASK.reset_arguments(episodes))
    found = [observation]
    for _ in range(STEPS):
        observation, *_ = env.step(FORWARD)
        found.append(observation)
    return found


@pytest.fixture(scope="module")
def plain() -> Observations:
    return sensed("range")


@pytest.fixture(scope="module")
def faulty() -> Callable[[str], Observations]:
    known: dict[str, Observations] = {}

    def of(fault: str) -> Observations:
        if fault not in known:
            known[fault] = sensed(fault)
        return known[fault]

    return of


Faulty = Callable[[str], Observations]


def stacked(observations: Observations, key: str = "range") -> NDArray[Any]:
    """One sensor's readings, ``(steps, rows)``."""
    return np.array([observation[key][:, 0] for observation in observations])


@pytest.mark.parametrize("fault", ["late", "jitter"])
def test_late_readings_are_those_of_the_time_that_their_age_tells(
    fault: str, plain: Observations, faulty: Faulty
) -> None:
    now, then = stacked(plain), stacked(faulty(fault))
    ages = np.rint(stacked(faulty(fault), "age") / TASK.time_step).astype(int)
    assert ages.max() == {"late": 4, "jitter": 8}[fault]

    steps = np.arange(STEPS + 1)[:, np.newaxis] - ages
    assert (then == np.take_along_axis(now, steps, axis=0)).all()


def test_frozen_readings_repeat_themselves_for_a_while(faulty: Faulty) -> None:
    repeats = (np.diff(stacked(faulty("stuck"), "bearing"), axis=0) == 0).sum(0)
    assert (repeats >= 55).all()  # an episode that has ended repeats itself as well
    assert repeats.min() <= 105


@pytest.mark.parametrize("fault", ["blackout", "gone"])
def test_readings_are_gone_from_some_time_on(fault: str, faulty: Faulty) -> None:
    missing = np.isnan(stacked(faulty(fault)))
    first = missing.argmax(0)
    assert ((first >= 40) & (first <= 200)).all()
    last = missing[-1] if fault == "gone" else missing.sum(0) <= 100
    assert last.all()


def test_one_reading_in_twenty_is_an_outlier(plain: Observations, faulty: Faulty) -> None:
    wrong = stacked(faulty("outliers")) != stacked(plain)
    assert 0.02 < wrong.mean() < 0.1


def test_erratic_readings_are_wrong_from_some_time_on(plain: Observations, faulty: Faulty) -> None:
    wrong = stacked(faulty("erratic")) != stacked(plain)
    first = wrong.argmax(0)
    assert ((first >= 40) & (first <= 200)).all() and wrong[-1].all()


def test_a_bias_is_constant(plain: Observations, faulty: Faulty) -> None:
    offset = stacked(faulty("bias")) - stacked(plain)
    np.testing.assert_allclose(offset, 0.05, atol=1e-5)


def test_held_actions_are_told(faulty: Faulty) -> None:
    """Held is what was executed last: here that shows in the first steps only."""
    executed = np.array([observation["executed"] for observation in faulty("held")])
    assert (executed[0] == 0).all() and (executed[-1] == FORWARD).all()


def test_steps_take_as_long_as_is_told(plain: Observations, faulty: Faulty) -> None:
    """They drive evenly, so the clearance after a step tells how long it took."""
    told = np.array([observation["elapsed"] for observation in faulty("uneven")])[:60, :, 0]
    taken = np.rint(told / TASK.time_step).astype(int)
    assert set(np.unique(taken[1:])) == {1, 2, 3}

    steps = taken.cumsum(0) - 1
    np.testing.assert_array_equal(stacked(faulty("uneven"))[:60], stacked(plain)[steps, [0, 1, 2]])


@pytest.mark.parametrize("fault", FAULTS)
def test_the_same_seed_brings_the_same_fault(fault: str, faulty: Faulty) -> None:
    for key in faulty(fault)[0]:
        first, second = stacked(faulty(fault), key), stacked(sensed(fault), key)
        np.testing.assert_array_equal(first, second)


@pytest.mark.parametrize("name", ["nav2d", "pusht", "arm_push"])
def test_every_task_has_all_of_them(name: str) -> None:
    task = load(name)
    assert set(FAULTS) <= set(task.conditions)
    assert task.policy_options("late")["delay"] > 0
