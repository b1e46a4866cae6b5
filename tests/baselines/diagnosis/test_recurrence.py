"""Recurrence: similarity is that of the definition, and crossings are those that are there."""

import numpy as np
import pytest
from _inputs.histories import DT, circling

from aicon_baselines.diagnosis.recurrence import (
    find_period,
    normalised,
    similarity,
    upward_crossings,
)


def test_a_circle_is_alike_to_itself_as_the_cosine_of_its_phase() -> None:
    alike = similarity(circling(period=2.0))
    phases = 2 * np.pi * DT * np.arange(len(alike)) / 2.0
    assert alike == pytest.approx(np.cos(phases), abs=1e-9)


def test_noise_has_no_period() -> None:
    noise = np.random.default_rng(0).normal(size=(300, 3))
    assert find_period(noise) is None


def test_a_line_has_no_period() -> None:
    assert find_period(np.linspace(0, 1, 300)[:, np.newaxis]) is None


def test_what_does_not_move_has_no_period() -> None:
    assert find_period(np.ones((300, 2))) is None


def test_two_rounds_are_not_enough() -> None:
    assert find_period(circling(period=2.0)[:45]) is None
    assert find_period(circling(period=2.0)[:65]) == 20


def test_a_component_that_never_moves_counts_for_nothing() -> None:
    state = np.concatenate((circling(period=2.0), np.full((400, 1), 0.1)), axis=1)
    assert normalised(state)[:, 2] == pytest.approx(0.0)
    assert find_period(normalised(state)) == 20


def test_a_value_crosses_upward_after_it_was_below() -> None:
    values = np.array([0.0, 1.0, 0.5, 1.0, -1.0, 0.0, 1.0])
    assert upward_crossings(values, low=-0.5, high=0.5).tolist() == [6]
    assert upward_crossings(values, low=0.1, high=0.9).tolist() == [1, 6]
