"""A policy with a goal or an estimator more, and the memory that goes on in it."""

from collections.abc import Mapping
from typing import Any

import pytest
import torch
from _inputs import drifting, lean
from torch import Tensor

from aicon_torch import (
    Actuator,
    Deterministic,
    Goal,
    GraphError,
    ObservationError,
    Policy,
    Sensor,
    WorldModel,
)
from aicon_torch.export.codegen import has_compiler
from aicon_torch.parts import Landmark, clock

DOOR = Landmark("p_door", "z_door", noise=0.01, motion_noise=0.001, sees="position")
PUDDLE = Landmark("p_puddle", "z_puddle", noise=0.01, motion_noise=0.001, sees="position")

FORMS = ["readable"]
if has_compiler():
    FORMS.append("compiled")


def move(v: Tensor, dt: float) -> Tensor:
    return v * dt


def near_the_puddle(p_puddle: Tensor) -> Tensor:
    return torch.relu(1.0 - p_puddle.norm(dim=-1)) ** 2


def to_the_door() -> Policy:
    """The way to a door."""
    model = WorldModel(
        sensors={"z_door": Sensor(2, "m"), "z_elapsed": clock()},
        actuators={"v": Actuator(2, "m/s", limit=1.0)},
        estimators=[Deterministic("x_rob", move, is_motion=True), DOOR.estimator()],
        goals=[Goal("arrive", DOOR.expected_distance())],
        dt=0.1,
        clock="z_elapsed",
        dtype=torch.float64,
    )
    return Policy(model)


def told_of_the_puddle(policy: Policy) -> Policy:
    """The same policy with a sensor, an estimator and a goal more."""
    seen = policy.with_estimator(PUDDLE.estimator(), z_puddle=Sensor(2, "m"))
    return seen.with_goal(Goal("stay dry", near_the_puddle))


def seen_from(*place: float, batch: tuple[int, ...] = ()) -> dict[str, Tensor]:
    """Door and puddle."""
    robot = torch.tensor(place, dtype=torch.float64).expand(*batch, 2)
    door, puddle = torch.tensor([[4.0, 0.0], [2.2, 0.25]], dtype=torch.float64)
    return {"z_door": door - robot, "z_puddle": puddle - robot}


def after_some_steps(policy: Policy, batch: tuple[int, ...] = ()) -> Mapping[str, Tensor]:
    """A memory of it."""
    memory: Any = None
    for step in range(5):
        _, memory = policy.predict(seen_from(0.1 * step, 0.0, batch=batch), memory)
    return memory


def assert_close_to_reading(memory: Mapping[str, Tensor], now: dict[str, Tensor]) -> None:
    """To what the robot moves in a step: what it did last moves what is new as well."""
    error = memory["p_puddle"] - now["z_puddle"]
    assert (error.norm(dim=-1) < 0.1).all()


@pytest.mark.parametrize("form", FORMS)
def test_a_memory_goes_on_where_an_estimator_and_a_goal_are_added(form: str) -> None:
    """All that it knew is as if nothing had been added; the new begins with its first reading."""
    policy = to_the_door() if form == "readable" else to_the_door().compile()
    memory, now = after_some_steps(policy), seen_from(1.4, 0.3)
    grown = told_of_the_puddle(policy)

    _, expected = policy.predict(now, memory)
    action, found = grown.predict(now, memory)
    for name in ("p_door", "P_door", "x_rob", "z_door.missed", "steps"):
        torch.testing.assert_close(found[name], expected[name])
    assert_close_to_reading(found, now)
    assert action[1] < -0.1  # it turns aside

    action, found = grown.predict(now, found)
    assert found["steps"] == expected["steps"] + 1


@pytest.mark.skipif(not has_compiler(), reason="there is no C compiler")
def test_what_grows_of_a_compiled_policy_is_compiled() -> None:
    grown = told_of_the_puddle(to_the_door().compile())
    _, memory = grown.predict(seen_from(0.0, 0.0))
    assert type(memory).__name__ == "ExportedMemory"
    assert isinstance(told_of_the_puddle(to_the_door()).predict(seen_from(0.0, 0.0))[1], dict)


def test_a_model_with_an_estimator_more_keeps_what_else_it_has() -> None:
    old = to_the_door().model
    model = old.with_estimator(PUDDLE.estimator(), z_puddle=Sensor(2, "m"))
    assert (model.dt, model.clock, model.like.dtype) == (old.dt, old.clock, old.like.dtype)
    assert {*model.quantities} - {*old.quantities} == {"z_puddle", "p_puddle", "P_puddle"}
    assert list(model.with_goal(Goal("stay dry", near_the_puddle)).goals) == ["arrive", "stay dry"]
    assert list(old.goals) == ["arrive"]


def test_what_is_added_is_checked_as_in_any_model() -> None:
    policy = to_the_door()
    with pytest.raises(GraphError, match="'stay dry' reads 'p_puddle'.*Known: 'z_door'"):
        policy.with_goal(Goal("stay dry", near_the_puddle))
    with pytest.raises(GraphError, match="'arrive' is declared 2 times"):
        policy.with_goal(Goal("arrive", DOOR.expected_distance()))
    with pytest.raises(GraphError, match="'p_puddle' reads 'z_puddle'"):
        policy.with_estimator(PUDDLE.estimator())


def test_goals_that_are_switched_off_stay_off() -> None:
    policy = to_the_door()
    memory = policy.switch(after_some_steps(policy, (3,)), arrive=torch.tensor([1.0, 0.0, 0.5]))
    grown = told_of_the_puddle(policy)
    _, found = grown.predict(seen_from(1.4, 0.3, batch=(3,)), memory)
    expected = torch.tensor([[1.0, 1.0], [0.0, 1.0], [0.5, 1.0]], dtype=torch.float64)
    assert torch.equal(found["goals/active"], expected)


def test_a_row_begins_an_episode_in_the_step_in_which_something_is_added() -> None:
    policy = to_the_door()
    memory, now = after_some_steps(policy, (2,)), seen_from(1.0, 0.0, batch=(2,))
    _, found = told_of_the_puddle(policy).predict(now, memory, [False, True])
    assert found["steps"].tolist() == [6, 1]


def test_a_row_rests_until_the_new_estimator_has_a_reading_to_begin_with() -> None:
    policy = to_the_door()
    memory, now = after_some_steps(policy, (2,)), seen_from(1.4, 0.3, batch=(2,))
    grown = told_of_the_puddle(policy)

    unseen = now | {
        "z_puddle": torch.where(torch.tensor([[True], [False]]), now["z_puddle"], torch.nan)
    }
    action, found = grown.predict(unseen, memory)
    assert (action[0] != 0).any() and (action[1] == 0).all()

    action, found = grown.predict(now, found)
    assert (action != 0).any(-1).all()
    assert_close_to_reading(found, now)


def test_a_memory_goes_on_over_several_additions_and_in_act() -> None:
    policy = to_the_door()
    memory = after_some_steps(policy)
    grown = told_of_the_puddle(told_of_another(policy))
    _, found = grown.predict(seen_from(1.0, 0.0), memory)
    assert found["steps"] == 6

    policy.act(seen_from(0.0, 0.0))
    grown = told_of_another(policy)
    grown.act(seen_from(0.1, 0.0))
    assert grown._memory is not None and grown._memory["steps"] == 2


def told_of_another(policy: Policy) -> Policy:
    """With a goal that asks for little."""
    return policy.with_goal(Goal("slow", lambda v: v.square().sum(-1)))


def test_what_it_perceives_by_are_the_values_of_the_memory() -> None:
    told: list[Any] = []

    def perception(observation: Any, values: Any, starts: Any) -> Any:
        told.append(values)
        return observation

    plain = to_the_door()
    policy = Policy(plain.model, perception=perception)
    memory = after_some_steps(policy)
    told_of_the_puddle(policy).predict(seen_from(1.0, 0.0), memory)
    assert "p_door" in told[-1] and "p_puddle" not in told[-1]


def test_another_memory_is_refused_as_ever() -> None:
    grown = told_of_the_puddle(to_the_door())
    memory = after_some_steps(grown)
    with pytest.raises(ObservationError, match="not a memory of this policy"):
        to_the_door().predict(seen_from(0.0, 0.0), memory)

    policy = to_the_door()
    with pytest.raises(ObservationError, match=r"batch of 'z_door' is \(2,\)"):
        memory = after_some_steps(policy, (2,))
        told_of_the_puddle(policy).predict(seen_from(0.0, 0.0, batch=(3,)), memory)
    with pytest.raises(ObservationError, match="take a step with it first"):
        told_of_the_puddle(policy).switch(memory, **{"stay dry": False})


def test_the_navigation_takes_a_goal_in_the_middle_of_an_episode() -> None:
    """What it remembers of exploring and of its motion goes on with the rest."""
    policy, memory = lean("nav2d"), None
    readings = drifting(40)
    for reading in readings[:30]:
        _, memory = policy.predict(reading, memory)

    berth = Goal("wide berth", lambda x_obs: 0.0 * x_obs[..., 0])
    grown = policy.with_goal(berth)
    for reading in readings[30:]:
        _, memory = grown.predict(reading, memory)
    assert memory is not None and memory["steps"] == 40
