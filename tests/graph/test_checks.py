"""What cannot work is refused at construction, each with its culprit: names and structure."""

from collections.abc import Callable
from typing import Any

import pytest
import torch
from _inputs import MOVE, TRACK, approach, match, move, near, tracked_point, tracking_model
from torch import Tensor

from aicon_torch import (
    Actuator,
    Deterministic,
    DirectDescent,
    Goal,
    GraphError,
    LateEKF,
    Measurement,
    Policy,
    Sensor,
    WorldModel,
)
from aicon_torch.parts import Landmark

LATE: dict[str, Any] = {
    "predict": approach,
    "noise": 0.1,
    "initial": ((1.0, 2.0), 1.0),
    "correct": [Measurement(match, 0.1, size=2)],
    "sensor": "z",
    "steps": 3,
    "moved_by": {"x": 2},
}


def late_model(moved_by: dict[str, int]) -> WorldModel:
    """Seen late, and felt at once."""
    felt = Measurement(lambda p, f: p - f, 0.1, size=2)
    point = LateEKF("p", "P", **LATE | {"moved_by": moved_by}, prompt=[felt])
    sensors = {"z": Sensor(2, "m", age=0.1), "f": Sensor(2, "m")}
    return tracking_model(MOVE, point, sensors=sensors)


def misspelt(p: Tensor, speed: Tensor) -> Tensor:
    return p - speed


MISNAMED: dict[str, tuple[Callable[[], Any], str]] = {
    "misspelt in a function": (
        lambda: tracking_model(Deterministic("x", lambda aa: aa), TRACK),
        r"'x' reads 'aa'.*Known: 'z', 'a', 'x', 'p', 'P', 'dt'",
    ),
    "misspelt in a filter": (
        lambda: tracking_model(MOVE, tracked_point(predict=misspelt)),
        r"'p' reads 'speed'.*'z', 'a', 'x'",
    ),
    "misspelt in a measurement": (
        lambda: tracking_model(
            MOVE, tracked_point(correct=[Measurement(lambda p, z_tar: p - z_tar, 0.1, size=2)])
        ),
        r"'p' reads 'z_tar'.*'z', 'a'",
    ),
    "misspelt covariance of a partner": (
        lambda: tracking_model(
            MOVE,
            tracked_point(
                correct=[Measurement(lambda p, x: p - x, 0.1, uncertain={"x": "P_x"}, size=2)]
            ),
        ),
        r"'p' reads 'P_x'",
    ),
    "misspelt in a goal": (
        lambda: tracking_model(goals=[Goal("near", lambda q: q.sum(-1))]),
        r"'near' reads 'q'.*'p', 'P'",
    ),
    "a name twice": (
        lambda: tracking_model(MOVE, Deterministic("x", move), TRACK),
        r"'x' is declared 2 times",
    ),
    "a sensor's name for an estimate": (
        lambda: tracking_model(MOVE, TRACK, Deterministic("z", move)),
        r"'z' is declared 2 times",
    ),
    "a goal twice": (
        lambda: tracking_model(goals=[Goal("near", near), Goal("near", near)]),
        r"'near' is declared 2 times",
    ),
    "a name of what is remembered": (
        lambda: tracking_model(MOVE, TRACK, Deterministic("steps", move)),
        "'steps' is taken",
    ),
    "the time step's name": (
        lambda: tracking_model(MOVE, TRACK, Deterministic("dt", lambda a: a)),
        r"'dt' is taken",
    ),
    "a name of the memory": (
        lambda: tracking_model(goals=[Goal("near/by", near)]),
        r"'near/by' is taken",
    ),
    "no name": (
        lambda: tracking_model(goals=[Goal("", near)]),
        r"called ''",
    ),
    "what a layer calls its input": (
        lambda: tracking_model(Deterministic("x", lambda input: input), TRACK),
        r"'x' reads 'input'.*wired by Interconnection\(layer",
    ),
    "a flag's name": (
        lambda: tracking_model(sensors={"z": Sensor(2, "m"), "z.present": Sensor(1, "1")}),
        r"'z.present' is taken",
    ),
}


INCOMPLETE: dict[str, tuple[Callable[[], Any], str]] = {
    "a type without fractions": (
        lambda: tracking_model(dtype=torch.int64),
        r"torch.int64.*floating-point",
    ),
    "a type without the age of what never came": (
        lambda: tracking_model(dtype=torch.float16),
        r"torch.float16.* numbers up to 1e\+09",
    ),
    "a function that changes what it reads": (
        lambda: tracking_model(Deterministic("x", lambda a, dt: a.mul_(dt)), TRACK),
        "'x' changes 'a' in place",
    ),
    "sensors without names": (
        lambda: tracking_model(sensors=[Sensor(2, "m")]),
        r"sensors: expected them by name, \{'name': Sensor\(...\)\}, got list",
    ),
    "a part in place of its estimator": (
        lambda: tracking_model(Landmark("p", "z", noise=0.1, motion_noise=0.1)),
        r"estimators: .*Landmark.*; call its .estimator\(\)",
    ),
    "a cost in place of a goal": (
        lambda: tracking_model(goals=[near]),
        r"goals: expected a sequence of Goal\('name', cost\), got in it <function near",
    ),
    "estimators that are gone once they are read": (
        lambda: tracking_model(estimators=iter([MOVE, TRACK])),
        r"estimators: expected a list or a tuple, got list_iterator",
    ),
    "a time step of nothing": (lambda: tracking_model(dt=0.0), r"dt=0.0: expected .* > 0, in s"),
    "a time step in words": (lambda: tracking_model(dt="0.1"), r"dt='0.1': expected"),
    "readings that are late, of no age": (
        lambda: tracking_model(MOVE, LateEKF("p", "P", **LATE)),
        r"'p' makes up for late readings of 'z', which has no age",
    ),
    "a prompt reading that nobody remembers": (
        lambda: late_model(moved_by={"x": 2}),
        r"prompt of 'p' reads the sensor 'f': moved_by has to remember 'f'.*got 'x'",
    ),
    "a prompt reading that may have been missing": (
        lambda: late_model(moved_by={"x": 2, "f": 2}),
        r"moved_by has to remember 'f.present'.*got 'x', 'f'",
    ),
    "no goals": (lambda: tracking_model(goals=[]), "at least one goal"),
    "no actuators": (lambda: tracking_model(actuators={}), "at least one actuator"),
    "no sensors": (lambda: tracking_model(sensors={}), "at least one sensor"),
    "functions in a circle": (
        lambda: tracking_model(
            Deterministic("x", lambda y: y),
            Deterministic("y", lambda x: x),
            goals=[Goal("g", lambda x: x.sum(-1))],
        ),
        r"circle: (x → y → x|y → x → y)",
    ),
    "a goal that no actuator moves": (
        lambda: tracking_model(goals=[Goal("near", near), Goal("idle", lambda z: z.sum(-1))]),
        r"Goal 'idle' depends on no actuator. It reads 'z'",
    ),
    "an actuator that moves no goal": (
        lambda: tracking_model(actuators={"a": Actuator(2, "m/s"), "b": Actuator(1, "m/s")}),
        r"No goal depends on the actuator 'b'. Goals: 'near'",
    ),
}


@pytest.mark.parametrize(("make", "culprit"), MISNAMED.values(), ids=MISNAMED.keys())
def test_names_that_do_not_fit_are_refused(make: Callable[[], Any], culprit: str) -> None:
    with pytest.raises(GraphError, match=culprit):
        make()


@pytest.mark.parametrize(("make", "culprit"), INCOMPLETE.values(), ids=INCOMPLETE.keys())
def test_a_graph_that_cannot_work_is_refused(make: Callable[[], Any], culprit: str) -> None:
    with pytest.raises(GraphError, match=culprit):
        make()


def test_what_is_late_and_what_is_remembered_make_a_model_that_works() -> None:
    model = late_model(moved_by={"x": 2, "f": 2, "f.present": 1})
    assert model.quantities["p_moves"].size == 5 * 4


def test_a_model_that_cannot_have_a_precision_keeps_its_own() -> None:
    policy = Policy(tracking_model(), law=DirectDescent(gain=1.0))
    for convert in (policy.half, lambda: policy.to("cpu", torch.float16)):
        with pytest.raises(GraphError, match=r"numbers up to 1e\+09, such as torch.float32 or"):
            convert()
    assert policy.model.like.dtype == torch.float64
    assert policy.float().model.like.dtype == torch.float32


def test_the_same_parts_make_a_model_that_works() -> None:
    assert [str(path) for path in tracking_model().paths()] == ["near → p → x → a"]


@pytest.mark.parametrize(
    ("part", "given"),
    [
        ("sensors", {"z": 2}),
        ("sensors", {"z": Sensor}),
        ("actuators", {"a": 2}),
        ("actuators", {"a": Sensor(2, "m")}),
        ("estimators", 2),
        ("goals", 2),
        ("goals", {Goal("near", near)}),
        ("goals", frozenset({Goal("near", near)})),
    ],
    ids=str,
)
def test_what_is_no_part_is_named(part: str, given: Any) -> None:
    parts: dict[str, Any] = {
        "sensors": {"z": Sensor(2, "m")},
        "actuators": {"a": Actuator(2, "m/s")},
        "estimators": [],
        "goals": [Goal("near", near)],
    }
    with pytest.raises(GraphError, match=f"^{part}: expected"):
        WorldModel(**{**parts, part: given})
