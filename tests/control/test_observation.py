"""Observations.

Bad ones are refused by sensor, missing ones are allowed where they are announced.
"""

from typing import Any

import numpy as np
import pytest
import torch
from _asserts import assert_same_memory
from _inputs import navigation, observation_with

from aicon_torch import (
    ActionLaw,
    Actuator,
    Affine,
    Goal,
    KalmanFilter,
    Measurement,
    ObservationError,
    Policy,
    Sensor,
    Sum,
    WorldModel,
)


@pytest.mark.parametrize(
    ("observation", "culprit"),
    [
        (observation_with(range=np.array([np.nan])), r"'z_obs'.*finite values in m"),
        (observation_with(bearing=np.array([np.inf])), r"'z_tar'.*finite values in rad"),
        (observation_with(bearing=np.array([-np.inf])), r"'z_tar'"),
        ({"range": np.array([1.0])}, r"'z_tar'.*no 'bearing'.*'range'.*\(\*batch, 1\) in rad"),
        ({}, r"'z_tar'.*no 'bearing'"),
        (
            observation_with(range=np.array([1.0, 2.0])),
            r"'z_obs'.*expected shape \(.*1\), got \(2,\)",
        ),
        (observation_with(range=np.array(1.0)), r"'z_obs'.*got \(\)"),
        (observation_with(range=np.array([[1.0]])), r"'z_obs'.*got \(1, 1\)"),
        (observation_with(range=np.ones((3, 1))), r"'z_obs'.*got \(3, 1\)"),
        (observation_with(range=np.array(["near"])), r"'z_obs'.*numbers in m"),
        (observation_with(range=None), r"'z_obs'.*numbers in m"),
        (observation_with(range=np.array([1.0j])), r"'z_obs'.*numbers in m"),
        (observation_with(range=np.array([None])), r"'z_obs'.*numbers in m"),
        (observation_with(bearing=[[0.1], [0.2, 0.3]]), r"'z_tar'"),
        (observation_with(range=torch.ones(3, 1)), r"'z_obs'.*got \(3, 1\)"),
        (np.array([0.3, 1.0]), "expected an observation by sensor"),
        (None, "expected an observation by sensor"),
    ],
)
def test_a_bad_observation_is_refused_by_sensor(observation: Any, culprit: str) -> None:
    _, memory = navigation("aicon").predict(observation_with())

    for state in (None, memory):
        with pytest.raises(ObservationError, match=culprit):
            navigation("aicon").predict(observation, state)
        with pytest.raises(ObservationError, match=culprit):
            navigation("aicon").estimate(observation, state)


def test_bad_rows_of_a_batch_are_refused() -> None:
    with pytest.raises(ObservationError, match="'z_obs'"):
        navigation("aicon").predict(
            observation_with(bearing=np.zeros((2, 1)), range=np.array([[1.0], [np.nan]]))
        )


def test_optional_readings_may_be_anything_that_is_no_number() -> None:
    reach = Goal("reach", lambda x: (x**2).sum(-1))

    model = WorldModel(
        sensors={"z": Sensor(2, "m", key="camera", optional=True), "w": Sensor(1, "m")},
        actuators={"a": Actuator(2, "m/s")},
        estimators=[
            KalmanFilter("x", "P", predict=Affine(x=1.0, a=0.1), noise=0.1, initial=((1.0, 1.0), 1.0), correct=[
                Measurement(Affine(x=1.0, z=-1.0), 0.1, size=2)
            ])
        ],
        goals=[reach],
    )  # fmt: skip

    policy = Policy(model, Sum(), ActionLaw(1.0))
    here = {"w": np.zeros(1)}
    expected = policy.predict(here)[0]
    for nothing in (np.array([np.nan, np.nan]), np.array([np.inf, 0.0]), np.array([0.0, np.nan])):
        assert np.array_equal(policy.predict(here | {"camera": nothing})[0], expected)

    with pytest.raises(ObservationError, match=r"'z'.*got \(3,\)"):
        policy.predict(here | {"camera": np.zeros(3)})


def test_readings_saturate_at_the_sensor_s_range() -> None:
    far, farther = (
        navigation("aicon").predict(observation_with(range=np.array([r])))[1] for r in (1e3, 1e30)
    )
    assert_same_memory(far, farther, 0.0)


def test_what_no_sensor_reads_is_ignored() -> None:
    more = observation_with(position=np.array([np.nan, 1.0]), target="there")
    assert_same_memory(
        navigation("aicon").predict(observation_with())[1],
        navigation("aicon").predict(more)[1],
        0.0,
    )
