"""What the robot did in the end is recognised in episodes of which it is known."""

import numpy as np
import pytest
from _inputs.histories import DT, STEPS, circling, history, resting, straight
from hypothesis import given
from hypothesis import strategies as st

from aicon_baselines.diagnosis import diagnose
from aicon_baselines.diagnosis.behaviour import find_behaviour


@given(period=st.floats(0.6, 6.0), noise=st.floats(0.0, 0.2))
def test_a_cycle_has_its_period(period: float, noise: float) -> None:
    found = find_behaviour(history(circling(period, noise)))

    assert found.kind == "cycle"
    assert found.period == pytest.approx(period, abs=0.7 * DT)


def test_a_cycle_begins_where_the_robot_began_to_circle() -> None:
    state = np.concatenate((resting(5.0)[:200], circling(3.0)[:200]))

    found = find_behaviour(history(state))

    assert found.kind == "cycle"
    assert found.begin == pytest.approx(200 * DT, abs=3.0)


def test_coming_back_at_intervals_that_differ_is_told_as_such() -> None:
    generator = np.random.default_rng(1)
    rounds = [np.sin(np.linspace(0, 2 * np.pi, generator.integers(8, 60))) for _ in range(20)]
    state = np.concatenate(rounds)[:STEPS, np.newaxis]

    found = find_behaviour(history(state))

    assert (found.kind, "to and fro" in found.text) == ("cycle", True)


@given(since=st.floats(1.0, 30.0))
def test_a_standstill_is_found_with_its_beginning(since: float) -> None:
    found = find_behaviour(history(resting(since)))

    assert found.kind == "standstill"
    assert found.begin == pytest.approx(since, abs=0.03 * since + DT)


def test_noise_around_one_place_is_neither_a_cycle_nor_a_way() -> None:
    noise = np.random.default_rng(2).normal(size=(STEPS, 2))
    assert find_behaviour(history(noise)).kind == "wandering"


def test_a_cost_that_still_falls_is_progress() -> None:
    cost = np.linspace(5.0, 1.0, STEPS)
    found = find_behaviour(history(straight(), costs={"arrive": cost}))

    assert found.kind == "progress"
    assert found.subjects == ("arrive",)


def test_a_cost_that_fell_long_ago_is_none() -> None:
    cost = np.maximum(np.linspace(5.0, -5.0, STEPS), 1.0)
    assert find_behaviour(history(straight(), costs={"arrive": cost})).kind == "wandering"


def test_units_do_not_matter() -> None:
    state = circling(3.0, 0.1)
    in_millimetres = diagnose(history(1e3 * state)).behaviour
    assert in_millimetres == diagnose(history(state)).behaviour


def test_an_episode_that_succeeded_needs_no_reason() -> None:
    assert "succeeded" in str(diagnose(history(resting(5.0), success=True)))
