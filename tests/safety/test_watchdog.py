"""The watchdog: on readings that are gone, frozen or impossible nothing moves for long."""

from typing import Any

import numpy as np
import pytest
import torch
from _inputs import drifting, navigation
from torch import Tensor

from aicon_torch import (
    EKF,
    Actuator,
    DirectDescent,
    Goal,
    GraphError,
    Measurement,
    Policy,
    Sensor,
    Sum,
    WorldModel,
)

DT = 0.1


def residual(x: Tensor, z: Tensor) -> Tensor:
    return x - z


def move(x: Tensor, a: Tensor) -> Tensor:
    return x + DT * a


def policy(**sensor: Any) -> Policy:
    """A point that goes to the right at full speed, and reads where it is."""
    place = EKF(
        "x",
        "P",
        predict=move,
        noise=1e-4,
        initial=((0.0, 0.0), 1.0),
        correct=[Measurement(residual, 1e-4, size=2)],
    )
    model = WorldModel(
        sensors={"z": Sensor(2, "m", key="place", **sensor)},
        actuators={"a": Actuator(2, "m/s", limit=1.0, key="executed")},
        estimators=[place],
        goals=[Goal("right", lambda x: -x[..., 0])],
        dt=DT,
        dtype=torch.float64,
    )
    return Policy(model, Sum(), DirectDescent(smoothing=0.0))


def speeds(policy: Policy, places: Any) -> list[float]:
    """The speed after each reading."""
    memory, found = None, []
    for place in places:
        action, memory = policy.predict({"place": np.array(place)}, memory)
        found.append(float(np.linalg.norm(action)))
    return found


GONE = [np.nan, np.nan]
MOVING = [[0.1 * step, 0.0] for step in range(10)]


def test_without_readings_the_command_decays_to_rest() -> None:
    found = speeds(policy(max_age=0.2), [*MOVING[:3], *[GONE] * 5, *MOVING[8:]])
    assert found == pytest.approx([1, 1, 1, 1, 1, 0.5, 0, 0, 1, 1])


def test_nobody_watches_a_sensor_without_a_largest_age() -> None:
    assert speeds(policy(), [*MOVING[:3], *[GONE] * 5]) == pytest.approx([1.0] * 8)


def test_a_reading_that_repeats_itself_while_it_should_change_is_none() -> None:
    """Until it changes; a point that stood still may repeat itself."""
    frozen = [MOVING[3]] * 5
    found = speeds(policy(max_age=0.1, driven_by="a"), [*MOVING[:4], *frozen, *MOVING[5:]])
    assert found == pytest.approx([1, 1, 1, 1, 1, 0, 0, 0, 0, 1, 1, 1, 1, 1])


@pytest.mark.parametrize("scale", [1.0, -1.0])
def test_within_its_range_a_sensor_freezes_whatever_its_scale(scale: float) -> None:
    sensor = {"max_age": 0.1, "driven_by": "a", "range": (-5.0, 5.0), "scale": scale}
    found = speeds(policy(**sensor), [*MOVING[:4], *[MOVING[3]] * 5])
    assert found[-1] == 0.0


def test_a_reading_that_jumps_farther_than_it_can_is_none_for_a_while() -> None:
    """Where it stays, it is believed in the end."""
    watched = policy(rate_limit=2.0)
    memory = None
    present = []
    for place in [*MOVING[:3], *[[1.0, 0.0]] * 5]:
        _, memory = watched.predict({"place": np.array(place)}, memory)
        present.append(bool(memory["z.present"]))
    assert present == [True] * 3 + [False] * 3 + [True] * 2


def test_after_an_outlier_nothing_is_believed_until_readings_agree() -> None:
    """However long that takes; then the estimate begins anew."""
    generator = np.random.default_rng(0)
    places = [[50.0, 0.0], *generator.uniform(-100, 100, (30, 2)), *[[1.0, 0.0]] * 4]
    watched, memory, believed = policy(rate_limit=2.0), None, []
    for place in places:
        _, memory = watched.predict({"place": np.array(place)}, memory)
        believed.append(bool(memory["z.present"]))

    assert believed == [True] + [False] * 33 + [True]
    assert memory is not None and memory["z.restart"]
    torch.testing.assert_close(memory["x"], torch.tensor([1.0, 0.0]).double(), atol=0.05, rtol=0)


def test_a_reading_that_cannot_be_is_none() -> None:
    watched = policy(is_possible=lambda reading: reading[..., 1] < 1.0)
    _, memory = watched.predict({"place": np.zeros((2, 2))})
    _, memory = watched.predict({"place": np.array([[0.0, 0.0], [0.0, 2.0]])}, memory)
    assert memory["z.present"].tolist() == [True, False]


def test_an_angle_may_go_round() -> None:
    watched, memory = policy(rate_limit=2.0, period=2 * np.pi), None
    for angle in (3.1, -3.1):
        _, memory = watched.predict({"place": np.array([angle, 0.0])}, memory)
        assert memory["z.present"]


def test_an_older_reading_than_the_last_is_none() -> None:
    watched, memory = policy(age_key="age"), None
    present = []
    for age in (0.0, 0.05, 0.3, 0.2, 0.0):
        reading = {"place": np.zeros(2), "age": np.array(age)}
        _, memory = watched.predict(reading, memory)
        present.append(bool(memory["z.present"]))
    assert present == [True, True, False, True, True]
    assert memory is not None and memory["z.age"] == 0.0


def test_readings_that_are_late_anyway_may_not_stay_away_for_longer() -> None:
    """What is heard counts, not how old it is: it stands 0.2 s after the last one came."""
    watched, memory = policy(age_key="age", max_age=0.9, max_gap=0.1), None
    found = []
    for step in range(8):
        place = np.array(MOVING[step] if step < 4 else GONE)
        action, memory = watched.predict({"place": place, "age": np.array(0.8)}, memory)
        found.append(float(np.linalg.norm(action)))
    assert found == pytest.approx([1, 1, 1, 1, 1, 0, 0, 0])


@pytest.mark.parametrize(
    ("place", "age", "speed"),
    [([0.05, 0.0], 0.35, 1.0), ([5.0, 0.0], 0.35, 0.0), ([0.3, 0.0], "same", 0.0)],
    ids=["overtaken", "nonsense", "the same again"],
)
def test_a_reading_that_was_overtaken_says_that_there_are_some(
    place: list[float], age: Any, speed: float
) -> None:
    watched, memory = policy(age_key="age", max_age=0.9, max_gap=0.1, rate_limit=2.0), None
    for step in range(4):
        _, memory = watched.predict({"place": np.array(MOVING[step]), "age": np.array(0.0)}, memory)
    for step in range(1, 3):
        old = 0.1 * step if age == "same" else age + 0.03 * step
        reading = {"place": np.array(place), "age": np.array(old)}
        action, memory = watched.predict(reading, memory)
    assert memory is not None and not memory["z.present"]
    assert np.linalg.norm(action) == pytest.approx(speed)


def test_the_executed_action_takes_the_place_of_the_one_that_was_sent() -> None:
    watched = policy()
    _, memory = watched.predict({"place": np.zeros(2)})
    told = {"place": np.full(2, np.nan), "executed": np.array([0.0, -0.5])}
    _, after = watched.predict(told, memory)
    torch.testing.assert_close(after["x"], memory["x"] + DT * torch.tensor([0.0, -0.5]).double())


def test_it_says_why() -> None:
    _, memory = navigation().predict(drifting(1)[0])
    for _ in range(5):
        gone = {"bearing": np.full(1, np.nan), "range": np.array([1.0])}
        _, memory = navigation().predict(gone, memory)

    explanation = navigation().explain(memory)
    assert "no reading of 'bearing': the last is 0.25 s old" in explanation.alerts
    assert "0% of the action is executed" in str(explanation)


@pytest.mark.parametrize(
    "bad", [{"max_age": 0.0}, {"max_gap": 0.0}, {"rate_limit": -1.0}, {"period": np.nan}]
)
def test_times_must_be_positive(bad: dict[str, Any]) -> None:
    with pytest.raises(GraphError, match=next(iter(bad))):
        Sensor(1, "m", **bad)


def test_what_drives_a_reading_must_be_an_actuator() -> None:
    with pytest.raises(GraphError, match=r"driven_by='b'.*'a'"):
        policy(driven_by="b")


def test_how_far_a_reading_can_be_goes_by_when_it_was_taken() -> None:
    """Late ones come as fast as prompt ones: in 0.1 s it cannot have gone 0.5 m."""
    watched, memory = policy(age_key="age", rate_limit=2.0), None
    present = []
    for x, age in [(0.0, 0.4), (0.1, 0.4), (0.6, 0.4), (0.6, 0.0)]:
        reading = {"place": np.array([x, 0.0]), "age": np.array(age)}
        _, memory = watched.predict(reading, memory)
        present.append(bool(memory["z.present"]))
    assert present == [True, True, False, True]


def test_a_frozen_reading_stays_none_after_an_outlier() -> None:
    """Nor is one that could be, but is alone; four in a row that agree are believed again."""
    watched, memory = policy(max_age=0.1, driven_by="a", rate_limit=2.0), None
    frozen, wrong = [MOVING[3]] * 5, [[9.0, 0.0], MOVING[3], GONE, [0.9, 0.0], MOVING[3]]
    again = [[0.4 + 0.01 * step, 0.0] for step in range(4)]
    present = []
    for place in [*MOVING[:4], *frozen, *wrong, *again]:
        _, memory = watched.predict({"place": np.array(place)}, memory)
        present.append(bool(memory["z.present"]))
    assert present == [True] * 4 + [False] * 13 + [True]


def test_a_reading_that_comes_twice_is_not_frozen() -> None:
    """Its age says that it is the same one: the next that is newer is believed at once."""
    watched, memory = policy(age_key="age", driven_by="a", rate_limit=2.0), None
    present = []
    for x, age in [(0.0, 0.0), (0.1, 0.0), (0.1, 0.1), (0.2, 0.1), (0.2, 0.0)]:
        reading = {"place": np.array([x, 0.0]), "age": np.array(age)}
        _, memory = watched.predict(reading, memory)
        present.append(bool(memory["z.present"]))
    assert present == [True, True, False, True, False]
