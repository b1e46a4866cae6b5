"""Foresight: steps down the potential that the model foresees, and where they lead."""

import dataclasses
import math
from typing import Any

import pytest
import torch
from _asserts import assert_rows_stand_alone
from _inputs import normal, off_the_wall, steered, walled
from torch import Tensor

from aicon_torch import (
    Actuator,
    Deterministic,
    DirectDescent,
    Foresight,
    Goal,
    OptionError,
    Policy,
    Sensor,
    Sum,
    WorldModel,
)

LIMITED = Actuator(2, "m/s", 0.5)


def foreseeing(goal: tuple[float, float], constraints: Any = (), **options: Any) -> Policy:
    """A point that goes to a goal with at most 2 m/s by foresight, unsmoothed."""
    law = Foresight(**{"smoothing": 0.0, **options})
    return Policy(steered(constraints, goal=goal).model, Sum(), law)


def to_goal(memory: dict[str, Tensor], goal: tuple[float, float]) -> Tensor:
    """The velocity, m/s, that brings the point to its goal within the step of 0.1 s."""
    return (torch.tensor(goal, dtype=torch.float64) - memory["x"]) / 0.1


# --- one step


@pytest.mark.parametrize("iteration", [1, 2, 7])
@pytest.mark.parametrize("scale", [1e-30, 1.0, 1e30])
def test_a_step_has_a_length_of_its_own_and_the_direction_of_the_descent(
    iteration: int, scale: float
) -> None:
    """ρ a_max / k, however steep it is."""
    gradient, count = scale * normal(9, 2), torch.tensor(float(iteration))
    start = torch.zeros(9, 2, dtype=torch.float64)
    action = Foresight(step=0.4).descend(start, gradient, count, LIMITED)
    expected = -0.4 * 0.5 / iteration * torch.nn.functional.normalize(gradient / scale, dim=-1)
    torch.testing.assert_close(action, expected)


def test_each_component_takes_a_share_of_its_own_limit() -> None:
    actuator = Actuator(2, "m", (1.0, 3.0))
    gradient = torch.tensor([-1.0, -1.0], dtype=torch.float64)
    start = torch.zeros_like(gradient)
    action = Foresight(step=0.5).descend(start, gradient, torch.tensor(1.0), actuator)
    torch.testing.assert_close(action, 0.5 * torch.tensor([1.0, 3.0]).double() / 2**0.5)


@pytest.mark.parametrize("limit", [0.5, (0.3, 0.7)], ids=str)
@pytest.mark.parametrize("step", [1 / 3, 5.0])
def test_no_number_of_steps_leaves_the_limit(limit: Any, step: float) -> None:
    actuator, law = Actuator(2, "m/s", limit), Foresight(step=step)
    ahead, action = -normal(7, 2), torch.zeros(7, 2, dtype=torch.float64)

    for iteration in range(1, law.iterations + 1):
        action = law.descend(action, ahead, torch.tensor(float(iteration)), actuator)
        torch.testing.assert_close(action, actuator.clip(action), rtol=1e-12, atol=1e-12)
    assert (action.norm(dim=-1) > 0.25).all()


@pytest.mark.parametrize("bad", [0.0, math.nan, math.inf, -math.inf])
def test_without_a_direction_it_goes_back_to_rest(bad: float) -> None:
    """A gradient of zero, or of a cost that overflows."""
    law, actuator = Foresight(step=0.4), Actuator(2, "m/s", (0.5, 0.5))
    action = torch.tensor([[0.3, -0.05], [0.0, -0.5]], dtype=torch.float64)
    nothing = torch.full_like(action, bad)

    nearer = law.descend(action, nothing, torch.tensor(1.0), actuator)
    expected = torch.tensor([[0.1, 0.0], [0.0, -0.3]], dtype=torch.float64)
    torch.testing.assert_close(nearer, expected)


def test_it_ends_with_the_low_pass() -> None:
    last, action = 0.1 * normal(4, 2), 0.1 * normal(4, 2, seed=1)
    law = Foresight(smoothing=0.3)
    torch.testing.assert_close(law.finish(action, last, LIMITED, 0.1), last + (action - last) / 4)

    sharp = dataclasses.replace(law, smoothing=0.0)
    assert torch.equal(sharp.finish(action, last, LIMITED, 0.1), action)


# --- where they lead: a point in the bowl |x − goal|², which moves by a·dt

NEAR = [(0.1, 0.05), (-0.15, 0.0), (0.0, 0.02)]


@pytest.mark.parametrize("goal", NEAR, ids=str)
@pytest.mark.parametrize("iterations", [10, 20, 50])
def test_a_minimum_within_reach_is_met_to_the_last_step(
    goal: tuple[float, float], iterations: int
) -> None:
    """To ρ a_max / K; a whole step at full speed would go beyond it."""
    policy = foreseeing(goal, iterations=iterations, step=0.5)
    reading = {name: 0.0 * value for name, value in walled(1)[0].items()}
    action, memory = policy.predict(reading)

    wish = to_goal(memory, goal)
    assert 0.1 < float(wish.norm()) < 2.0
    assert float((action - wish).norm()) <= 0.5 * 2.0 / iterations + 1e-12


@pytest.mark.parametrize("goal", [(3.0, -1.0), (-20.0, 0.0)], ids=str)
def test_a_minimum_far_away_is_gone_to_at_full_speed(goal: tuple[float, float]) -> None:
    action, memory = foreseeing(goal).predict(walled(1)[0])
    wish = to_goal(memory, goal)
    torch.testing.assert_close(action, 2.0 * wish / wish.norm())


def test_one_iteration_is_one_step_down_the_gradient_at_rest() -> None:
    goal = (0.1, 0.05)
    action, memory = foreseeing(goal, iterations=1, step=0.25).predict(walled(1)[0])
    wish = to_goal(memory, goal)
    torch.testing.assert_close(action, 0.25 * 2.0 * wish / wish.norm())


def test_it_foresees_what_the_constraints_leave() -> None:
    """Along a wall: what is no longer spent on the way into it goes on beside it."""
    reading = walled(1)[0]
    reading["z"] = torch.zeros_like(reading["z"])
    free, _ = foreseeing((3.0, -1.0)).predict(reading)
    held, memory = foreseeing((3.0, -1.0), [off_the_wall]).predict(reading)

    room = (reading["wall"] - memory["x"][:1]) / 0.1
    torch.testing.assert_close(held[:1], room)
    assert held[1] < free[1] - 0.05 < 0


def test_singles_are_rows_of_a_batch() -> None:
    policy = foreseeing((0.1, 0.05), smoothing=0.1)
    assert_rows_stand_alone(policy, walled(6, (3,)), rows=(0, 2))


def test_the_memory_tells_the_gradients_at_the_end_of_the_descent() -> None:
    """Where the last but one step has led: 2 (x + a dt − goal) dt, not the slope at rest."""
    goal, (reading,) = (0.1, 0.05), walled(1)
    _, memory = foreseeing(goal, iterations=3).predict(reading)
    before, _ = foreseeing(goal, iterations=2).predict(reading)

    slope = -2.0 * 0.1**2 * (to_goal(memory, goal) - before)
    stack = foreseeing(goal).trace(memory).quantities["a"]
    torch.testing.assert_close(stack.gradients.sum(-2), slope)


def test_the_decisions_of_a_step_can_be_explained() -> None:
    policy = foreseeing((3.0, -1.0))
    _, memory = policy.predict(walled(1)[0])
    report = policy.explain(memory).goals["reach"]
    cost = (memory["x"] - torch.tensor([3.0, -1.0], dtype=torch.float64)).square().sum()
    assert report.cost == pytest.approx(float(cost))
    assert report.predicted_change < 0


# --- errors


@pytest.mark.parametrize("limit", [math.inf, (1.0, math.inf)], ids=str)
def test_it_needs_a_limit_and_says_so(limit: Any) -> None:
    with pytest.raises(OptionError, match=r"'a' has limit=.*inf.*finite.*DirectDescent\(gain="):
        Foresight().check("a", Actuator(2, "m/s", limit))
    DirectDescent().check("a", Actuator(2, "m/s", limit))


def test_a_policy_checks_its_law() -> None:
    model = WorldModel(
        sensors={"z": Sensor(2, "m")},
        actuators={"a": Actuator(2, "m")},
        estimators=[Deterministic("x", lambda a, z: a + z)],
        goals=[Goal("reach", lambda x: (x**2).sum(-1))],
    )
    with pytest.raises(OptionError, match="Actuator 'a' has limit=inf"):
        Policy(model, Sum())
    Policy(model, Sum(), DirectDescent())


@pytest.mark.parametrize(
    ("options", "culprit"),
    [
        *(({"iterations": value}, f"iterations={value}") for value in (0, -1, 2.0, True)),
        *(({"step": value}, f"step={value}") for value in (0.0, -1.0, math.nan, math.inf)),
        *(({"smoothing": value}, f"smoothing={value}") for value in (-0.1, math.nan, math.inf)),
        *(({name: "a"}, f"{name}='a'") for name in ("step", "smoothing", "dither", "horizon")),
        *(({"dither": value}, f"dither={value}") for value in (-0.1, 1.1, math.nan)),
        *(({"dither_steps": value}, f"dither_steps={value}") for value in (0, -1, 2.0, True)),
    ],
)
def test_bad_constants_are_named(options: dict[str, Any], culprit: str) -> None:
    with pytest.raises(OptionError, match=culprit):
        Foresight(**options)
