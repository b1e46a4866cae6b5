"""Observations: bad ones are refused by sensor, missing ones allowed where that is announced."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import torch
from _asserts import assert_same_memory
from _inputs import BATCHES, navigation, normal, observation_with, point
from _inputs.tracking import tracking_model

from aicon_torch import (
    Actuator,
    Deterministic,
    DirectDescent,
    Goal,
    ObservationError,
    Policy,
    Sensor,
    Sum,
    WorldModel,
)


@pytest.mark.parametrize(
    ("observation", "culprit"),
    [
        (
            {"range": np.array([1.0])},
            r"'bearing'.*'z_tar'.*no 'bearing'.*'range'.*\(\*batch, 1\) in rad",
        ),
        ({}, r"'z_tar'.*no 'bearing'"),
        (observation_with(range=np.ones(2)), r"'z_obs'.*expected shape \(1,\), got \(2,\)"),
        (observation_with(range=np.array(1.0)), r"'z_obs'.*got \(\)"),
        (observation_with(range=np.array([[1.0]])), r"'z_obs'.*got \(1, 1\)"),
        (observation_with(range=np.ones((3, 1))), r"'z_obs'.*got \(3, 1\)"),
        (observation_with(range=np.array(["near"])), r"'z_obs'.*numbers in m"),
        (observation_with(range=np.array([1.0j])), r"'z_obs'.*numbers in m"),
        (observation_with(range=None), r"None; where there is no reading, give NaN"),
        (observation_with(range=np.array([None])), r"'z_obs'.*numbers in m"),
        (observation_with(bearing=[[0.1], [0.2, 0.3]]), r"'z_tar'"),
        (observation_with(range=torch.ones(3, 1)), r"'z_obs'.*got \(3, 1\)"),
        (np.array([0.3, 1.0]), "expected an observation by sensor"),
        (None, "expected an observation by sensor"),
    ],
)
def test_a_bad_observation_is_refused_by_sensor(observation: Any, culprit: str) -> None:
    _, memory = navigation().predict(observation_with())

    for state in (None, memory):
        with pytest.raises(ObservationError, match=culprit):
            navigation().predict(observation, state)
        with pytest.raises(ObservationError, match=culprit):
            navigation().estimate(observation, state)


@pytest.mark.filterwarnings("ignore")  # torch calls some of them prototypes
@pytest.mark.parametrize(
    ("make", "named"),
    [
        (lambda: torch.ones(1).to_sparse(), "sparse_coo"),
        (lambda: torch.ones(1, 1).to_sparse_csr(), "sparse_csr"),
        (lambda: torch.ones(1, device="meta"), "on meta"),
        (lambda: torch.quantize_per_tensor(torch.ones(1), 0.1, 0, torch.qint8), "qint8"),
        (lambda: torch.nested.nested_tensor([torch.ones(1)]), "nested"),
        (lambda: torch.nested.nested_tensor([torch.ones(1)], layout=torch.jagged), "nested"),
    ],
)
def test_a_tensor_that_is_not_dense_is_refused_by_name(
    make: Callable[[], torch.Tensor], named: str
) -> None:
    _, memory = navigation().predict(observation_with())
    for state in (None, memory):
        with pytest.raises(ObservationError, match=f"'z_obs'.*real numbers in m, got .*{named}"):
            navigation().predict(observation_with(range=make()), state)
    with pytest.raises(ObservationError, match=f"'goals/active'.*dense tensor, got .*{named}"):
        navigation().predict(observation_with(), memory | {"goals/active": make()})


def test_optional_readings_may_be_anything_that_is_no_number() -> None:
    model = WorldModel(
        sensors={"z": Sensor(2, "m", key="camera", optional=True), "w": Sensor(1, "m")},
        actuators={"a": Actuator(2, "m/s")},
        estimators=[point()],
        goals=[Goal("reach", lambda x: ((x - 1.0) ** 2).sum(-1))],
    )
    policy = Policy(model, Sum(), DirectDescent(1.0))
    here = {"w": np.zeros(1)}
    expected, _ = policy.predict(here)

    for nothing in ([np.nan, np.nan], [np.inf, 0.0], [0.0, np.nan]):
        action, _ = policy.predict(here | {"camera": np.array(nothing)})
        assert np.array_equal(action, expected)

    with pytest.raises(ObservationError, match=r"'z'.*got \(3,\)"):
        policy.predict(here | {"camera": np.zeros(3)})


@pytest.mark.parametrize("far", [1e4, -2.0, 1e300, np.inf, -np.inf, np.nan])
@pytest.mark.parametrize("kind", [np.asarray, torch.as_tensor])
def test_beyond_the_range_there_is_no_reading(far: float, kind: Any) -> None:
    _, memory = navigation().predict(observation_with())
    turned = observation_with(bearing=kind([0.31]), range=kind([far]))
    _, after = navigation().predict(turned, memory)

    assert not after["z_obs.present"] and after["z_tar.present"]
    assert after["z_obs.missed"] == 1 and after["z_obs.age"] == pytest.approx(0.05)
    assert after["z_obs"] == 1.0


@pytest.mark.parametrize("far", [-0.1, np.inf])
def test_a_range_may_have_one_end(far: float) -> None:
    sensors = {"z": Sensor(2, "m", range=(0.0, np.inf))}
    actuators = {"a": Actuator(2, "m/s", limit=1.0)}
    policy = Policy(tracking_model(sensors=sensors, actuators=actuators))
    _, memory = policy.predict({"z": np.array([[0.0, 1e9], [far, 1.0]])})
    assert memory["z.present"].tolist() == [True, False]


def masked_rows(values: list[float], masks: list[bool]) -> Any:
    """Rows ``(N, 1)``, as whoever stacks single readings has them."""
    pairs = zip(values, masks, strict=True)
    return [np.ma.masked_array([value], [mask]) for value, mask in pairs]


@pytest.mark.parametrize(
    "reading",
    [
        np.ma.masked_array([[1.5], [1.0]], [[True], [False]]),
        np.ma.masked_array([[2], [1]], [[True], [False]]),
        masked_rows([1.5, 1.0], [True, False]),
    ],
)
def test_what_is_masked_is_no_reading(reading: Any) -> None:
    first, second = (np.full((2, 1), bearing) for bearing in (0.3, 0.31))
    _, memory = navigation().predict({"bearing": first, "range": np.full((2, 1), 1.01)})
    _, after = navigation().predict({"bearing": second, "range": reading}, memory)
    nothing = {"bearing": second, "range": np.array([[np.nan], [1.0]])}
    _, expected = navigation().predict(nothing, memory)

    assert after["z_obs.present"].tolist() == [False, True]
    assert_same_memory(after, expected, 0.0)


@pytest.mark.filterwarnings("ignore")  # torch calls it a prototype
def test_what_a_masked_tensor_hides_is_no_reading() -> None:
    _, memory = navigation().predict(observation_with())
    hidden = torch.masked.masked_tensor(torch.ones(1), torch.tensor([False]))
    turned = observation_with(bearing=np.array([0.31]), range=hidden)
    _, after = navigation().predict(turned, memory)
    assert not after["z_obs.present"] and after["z_tar.present"]


def test_a_mask_that_hides_nothing_changes_nothing() -> None:
    _, expected = navigation().predict(observation_with())
    _, memory = navigation().predict(observation_with(range=np.ma.array([1.0])))
    assert_same_memory(memory, expected, 0.0)


def test_numbers_may_be_stored_in_any_way() -> None:
    _, expected = navigation().predict(observation_with(range=np.array([1.5])))

    for stored in (
        np.array([1.5], dtype=">f4"),
        np.array([1.5], dtype=np.longdouble),
        np.array([9.0, 1.5])[::-1][:1],
        np.array([1.5], dtype=np.float16),
        [1.5],
        (torch.tensor(1.5),),
    ):
        _, memory = navigation().predict(observation_with(range=stored))
        assert_same_memory(memory, expected, 0.0)


def test_what_no_sensor_reads_is_ignored() -> None:
    more = observation_with(position=np.array([np.nan, 1.0]), target="there")

    _, memory = navigation().predict(more)
    _, expected = navigation().predict(observation_with())
    assert_same_memory(memory, expected, 0.0)


def seen_at() -> Policy:
    """A point whose place and age may be missing."""
    sensor = Sensor(2, "m", key="place", optional=True, age_key="place_age")
    actuators = {"a": Actuator(2, "m/s", limit=1.0, key="executed")}
    return Policy(tracking_model(sensors={"z": sensor}, actuators=actuators))


@pytest.mark.parametrize("key", ["place", "place_age", "executed"])
def test_a_key_that_may_be_missing_and_is_misspelt_is_told_once(
    key: str, caplog: pytest.LogCaptureFixture
) -> None:
    whole = {"place": np.zeros(2), "place_age": np.zeros(()), "executed": np.zeros(2)}
    policy, other = seen_at(), {"x": np.zeros(1), f"{key}s": whole.pop(key)}
    memory = None
    for _ in range(3):
        _, memory = policy.predict(whole | other, memory)
    (record,) = caplog.records
    assert f"has no '{key}'" in record.getMessage() and f"it has '{key}s'" in record.getMessage()


def test_other_keys_are_not_taken_for_misspelt_ones(caplog: pytest.LogCaptureFixture) -> None:
    seen_at().predict({"pixels": np.zeros(3), "placard": 1, 3: 4, "place_age": np.zeros(())})
    seen_at().predict({"place": np.zeros(2), "places": 1})
    numbered = {"z": Sensor(2, "m", key=3, optional=True)}  # type: ignore[arg-type]  # wrong on purpose
    Policy(tracking_model(sensors=numbered), law=DirectDescent()).predict({"places": 1})
    assert not caplog.records


def test_without_any_reading_an_observation_is_that_of_one_robot() -> None:
    policy = seen_at()
    _, memory = policy.predict({"place": np.zeros((3, 2))})
    with pytest.raises(ObservationError, match=r"is \(3,\), .*of no reading, \(\)"):
        policy.predict({}, memory)

    nothing = {"place": np.full((3, 2), np.nan)}
    assert policy.predict(nothing, memory)[0].shape == (3, 2)


# --- units


@pytest.mark.parametrize("scale", [1e-3, (1e-3, 2e-3)], ids=str)
@pytest.mark.parametrize("kind", [np.asarray, torch.as_tensor])
@pytest.mark.parametrize("batch", BATCHES, ids=str)
def test_a_sensor_s_scale_leads_to_the_graph_s_unit(
    scale: Any, kind: Any, batch: tuple[int, ...]
) -> None:
    model = WorldModel(
        sensors={"z": Sensor(2, "px", range=(-100.0, 100.0), scale=scale)},
        actuators={"a": Actuator(2, "m")},
        estimators=[Deterministic("x", lambda a, z: a + z)],
        goals=[Goal("reach", lambda x: (x**2).sum(-1))],
        dtype=torch.float64,
    )
    pixels = 200.0 * normal(*batch, 2)
    pixels = pixels.clamp(-100.0, 100.0)
    _, memory = Policy(model, Sum(), DirectDescent(1.0)).predict({"z": kind(pixels)})

    # The range is in the unit of the instrument.
    expected = pixels * torch.tensor(scale, dtype=torch.float64)
    torch.testing.assert_close(memory["z"], expected)
    torch.testing.assert_close(memory["x"], expected)
