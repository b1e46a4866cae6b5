"""A rehearsed policy goes the shorter way around, and is the policy itself where none is chosen."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
import torch
from _asserts import assert_same_memory
from _inputs.shipped import quick
from torch import Tensor

from aicon_torch import (
    Actuator,
    Affine,
    Deterministic,
    Exploration,
    Goal,
    Interconnection,
    NullspaceProjection,
    OptionError,
    Policy,
    Rehearsal,
    Sensor,
    TrapEscape,
    WorldModel,
)
from aicon_torch.parts import Walls, norm
from aicon_torch.ways import WaysAlong

DT, ARRIVED = 0.1, 0.1
MAP = ["#########", "#       #", *["#   #   #"] * 6, "#       #", "#########"]
"""A wall whose lower end is near where the robot meets it, and whose upper end is far."""

AT_THE_WALL, IN_THE_OPEN, GOAL = (-3.0, -3.0), (1.0, 3.0), (3.0, 0.5)


def wandering() -> Policy:
    """A point that knows the map, and keeps clear of its walls."""
    walls = Walls.from_grid(MAP, radius=0.1)

    def far(p: Tensor, z_goal: Tensor) -> Tensor:
        return norm(p - z_goal)

    avoid = Interconnection(walls.collision_likelihood(0.04), ["p"])
    model = WorldModel(
        sensors={"z": Sensor(2, "m"), "z_goal": Sensor(2, "m")},
        actuators={"a": Actuator(2, "m/s", limit=1.0)},
        estimators=[Deterministic("p", Affine(z=1.0, a="dt"))],
        goals=[Goal("reach", far), Goal("avoid", avoid)],
        dt=DT,
        dtype=torch.float64,
    )
    escape = TrapEscape(progress="reach", hold="avoid", along="avoid", onward=True)
    return Policy(model, NullspaceProjection(exploration=Exploration(escape=escape)))


def moved(readings: Mapping[str, Tensor], memory: Mapping[str, Tensor]) -> dict[str, Tensor]:
    return {**readings, "z": readings["z"] + DT * memory["a"]}


def to_go(readings: Mapping[str, Tensor]) -> Tensor:
    return norm(readings["z"] - readings["z_goal"])


@pytest.fixture(scope="module")
def policy() -> Policy:
    return quick(wandering())


def seen(*places: tuple[float, float]) -> dict[str, Tensor]:
    z = torch.tensor(places, dtype=torch.float64)
    return {"z": z, "z_goal": z.new_tensor(GOAL).expand_as(z)}


def drive(policy: Any, readings: Mapping[str, Tensor], steps: int) -> Tensor:
    """Where the points are, ``(steps, rows, 2)``."""
    places, memory = [], None
    for _ in range(steps):
        _, memory = policy.predict(readings, memory)
        readings = moved(readings, memory)
        places.append(readings["z"])
    return torch.stack(places)


def steps_of(way: Tensor) -> int:
    """How many steps it takes to arrive, ``(steps, 2)``."""
    arrived = torch.linalg.vector_norm(way - way.new_tensor(GOAL), dim=-1) < ARRIVED
    assert arrived.any()
    return int(arrived.int().argmax())


def test_it_goes_the_shorter_way_around(policy: Policy) -> None:
    rehearsed = Rehearsal(policy, moved, to_go, ARRIVED)
    alone, better = (drive(p, seen(AT_THE_WALL), 200)[:, 0] for p in (policy, rehearsed))
    assert alone[:, 1].max() > 3 and better[:, 1].max() < 3
    assert steps_of(better) + 20 < steps_of(alone)


def test_where_nothing_is_in_the_way_it_is_the_policy(policy: Policy) -> None:
    rehearsed = Rehearsal(policy, moved, to_go, ARRIVED)
    places = seen(AT_THE_WALL, IN_THE_OPEN)
    alone, better = (drive(p, places, 60) for p in (policy, rehearsed))
    assert torch.equal(alone[:, 1], better[:, 1])
    assert torch.equal(better[:, 0], drive(rehearsed, seen(AT_THE_WALL), 60)[:, 0])


def test_it_decides_where_exploration_begins_and_now_and_then(policy: Policy) -> None:
    ways = WaysAlong(policy, every=7)
    readings, memory = seen(AT_THE_WALL, IN_THE_OPEN), None
    explored = torch.zeros(2, dtype=torch.bool)
    for _ in range(40):
        before = memory
        _, memory = policy.predict(readings, before)
        explores, is_time = memory["p/exploring"], memory["steps"] % 7 == 0
        expected = explores & (~explored | is_time)
        assert torch.equal(ways.begins(memory, before, None), expected)
        readings, explored = moved(readings, memory), explores
    assert explored.tolist() == [True, False]

    # The three ways: as it is, turned around, and no longer exploring.
    three = ways.of(memory, 0)
    assert torch.equal(three["p/average"][0], -three["p/average"][1])
    assert three["p/exploring"][:, 0].tolist() == [True, True, False]


def held(policy: Any, readings: Mapping[str, Any]) -> tuple[dict[str, Tensor], set[str]]:
    """The memory after a rehearsal at the wall, and what was imagined besides the readings."""
    imagined: set[str] = set()

    def imagine(seen: Mapping[str, Any], memory: Mapping[str, Tensor]) -> Mapping[str, Any]:
        imagined.update(seen)
        return {**seen, "z": seen["z"] + DT * memory["a"]}

    rehearsed, memory = Rehearsal(policy, imagine, to_go, ARRIVED, steps=60), None
    for _ in range(3):
        _, memory = rehearsed.predict(readings, memory)
    return memory, imagined - {"z", "z_goal"}


HELD = (-0.8, -2.5)
"""Where the wall is in the way."""

ARRAYS: dict[str, Any] = {
    "other byte order": lambda array: array.astype(">f8"),
    "backwards": lambda array: array[::-1].copy()[::-1],
    "a mask that hides nothing": np.ma.masked_invalid,
    "a list": lambda array: array.tolist(),
    "long": lambda array: array.astype(np.longdouble),
}


@pytest.mark.parametrize("changed", ARRAYS.values(), ids=ARRAYS.keys())
def test_arrays_of_any_kind_are_rehearsed_alike(policy: Policy, changed: Any) -> None:
    readings = {name: value.numpy() for name, value in seen(HELD, IN_THE_OPEN).items()}
    expected, _ = held(policy, readings)
    assert expected["p/exploring"].any()

    found, _ = held(policy, {name: changed(value) for name, value in readings.items()})
    assert_same_memory(found, expected, 0.0)


def test_what_else_an_observation_has_stays_as_it_is(policy: Policy) -> None:
    readings = {name: value.numpy() for name, value in seen(HELD, IN_THE_OPEN).items()}
    expected, _ = held(policy, readings)

    besides = {"task": "go", "count": 3, "camera": np.ones(3), "frames": np.ones((2, 4, 4))}
    found, imagined = held(policy, {**readings, **besides})
    assert_same_memory(found, expected, 0.0)
    assert imagined == besides.keys()


@pytest.mark.filterwarnings("ignore:The PyTorch API of MaskedTensors")
@pytest.mark.parametrize("masked", [np.ma.masked_array, torch.masked.masked_tensor])
def test_a_masked_reading_is_rehearsed_as_none(policy: Policy, masked: Any) -> None:
    z, goal = seen(HELD).values()
    _, memory = policy.predict({"z": z, "z_goal": goal})
    wrong = torch.full_like(z, 77.0)
    hidden = masked(wrong, torch.zeros(1, 2, dtype=torch.bool))
    if masked is np.ma.masked_array:
        hidden = masked(wrong.numpy(), np.ones((1, 2), dtype=bool))

    goals: list[Tensor] = []

    def imagine(readings: Mapping[str, Tensor], memory: Mapping[str, Tensor]) -> dict[str, Tensor]:
        goals.append(readings["z_goal"])
        return moved(readings, memory)

    ways = WaysAlong(policy, every=1)
    rehearsed = Rehearsal(policy, imagine, to_go, ARRIVED, steps=5, ways=ways)
    rehearsed.predict({"z": z, "z_goal": hidden}, memory)
    assert len(goals) == 5 and torch.stack(goals).isnan().all()


WRONG: dict[str, tuple[dict[str, Any], str]] = {
    "a policy": ({"policy": None}, "policy=None: expected Policy"),
    "a model": ({"imagine": None}, r"imagine=None: .* imagine\(readings, memory\)"),
    "a cost": ({"cost": 1.0}, r"cost=1.0: .* cost\(memory\)"),
    "a word": ({"enough": "near"}, "enough='near': expected 1 finite number"),
    "no number": ({"enough": math.nan}, "enough=nan"),
    "parts of a step": ({"steps": 2.5}, "steps=2.5: expected a whole number >= 1"),
    "no step": ({"steps": 0}, "steps=0"),
    "parts of a round": ({"rounds": 1.5}, "rounds=1.5: expected a whole number >= 1"),
    "a number of ways": ({"ways": 3}, "ways=3: expected Ways, such as WaysAlong"),
    "a kind of ways": ({"ways": WaysAlong}, r"expected an instance, WaysAlong\(policy\)"),
}


@pytest.mark.parametrize(("wrong", "told"), WRONG.values(), ids=WRONG.keys())
def test_an_argument_that_is_something_else_is_named(wrong: dict[str, Any], told: str) -> None:
    right: dict[str, Any] = {"imagine": moved, "cost": to_go, "enough": ARRIVED}
    with pytest.raises(OptionError, match=told):
        Rehearsal(**{"policy": wandering(), **right, **wrong})


def test_a_policy_that_does_not_explore_is_refused() -> None:
    model = wandering().model
    alone = WorldModel(
        sensors=model.sensors,
        actuators=model.actuators,
        estimators=[Deterministic("p", Affine(z=1.0, a="dt"))],
        goals=[Goal("reach", lambda p: norm(p))],
    )
    for policy in (Policy(model, NullspaceProjection(exploration=None)), Policy(alone)):
        with pytest.raises(OptionError, match="does not explore"):
            Rehearsal(policy, moved, to_go, ARRIVED)
    for every in (0, 2.5):
        with pytest.raises(OptionError, match=f"every={every}"):
            WaysAlong(wandering(), every=every)  # type: ignore[arg-type]
    with pytest.raises(OptionError, match="policy=3: expected Policy"):
        WaysAlong(3)  # type: ignore[arg-type]  # wrong on purpose
