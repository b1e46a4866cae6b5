"""A rehearsed policy goes the shorter way around, and is the policy itself where none is chosen."""

from collections.abc import Mapping
from typing import Any

import pytest
import torch
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


def test_a_policy_that_does_not_explore_is_refused() -> None:
    policy = Policy(wandering().model, NullspaceProjection(exploration=None))
    with pytest.raises(OptionError, match="does not explore"):
        Rehearsal(policy, moved, to_go, ARRIVED)
    with pytest.raises(OptionError, match="steps=0"):
        Rehearsal(wandering(), moved, to_go, ARRIVED, steps=0)
    with pytest.raises(OptionError, match="every=0"):
        WaysAlong(wandering(), every=0)
