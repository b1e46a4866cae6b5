"""Explanations: what a step decided, in numbers that can be checked."""

from typing import Any

import pytest
import torch
from _asserts import numeric_totals, rollout
from _inputs import Blueprint, blueprints, built, drifting, readings
from hypothesis import given
from torch import Tensor

from aicon_torch import (
    ActionLaw,
    Actuator,
    Deterministic,
    Exploration,
    Goal,
    NullspaceProjection,
    Policy,
    Sensor,
    SteepestPath,
    Sum,
    WorldModel,
    make_policy,
)

POLICY = make_policy(
    "nav2d", preset="as_in_text"
)  # the leader is compared with the second strongest


MEMORIES = rollout(POLICY, drifting(100))


@given(blueprints(derivatives=("model", "update")))
def test_the_predicted_change_is_the_slope_along_the_action(blueprint: Blueprint) -> None:
    """By finite differences of each goal, on random graphs."""
    model = built(blueprint)

    policy = Policy(model, NullspaceProjection(exploration=Exploration()), ActionLaw(0.5))
    memory = rollout(policy, [readings((), seed) for seed in range(3)])[-1]
    explanation = policy.explain(memory)
    action = {name: memory[name] for name in model.actuators}

    for name in model.goals:
        slopes = numeric_totals(model, memory, action, goals=[name])
        change = sum(float(slopes[actuator] @ action[actuator]) for actuator in action)
        assert explanation.goals[name].predicted_change == pytest.approx(change, rel=1e-5, abs=1e-7)
        cost = model.goals[name]({**memory, "dt": model.dt})
        assert explanation.goals[name].cost == pytest.approx(float(cost))


def test_on_a_straight_slope_the_prediction_comes_true() -> None:
    def slope(x: Tensor) -> Tensor:
        return 3.0 * x[..., 0] - x[..., 1]

    model = WorldModel(
        sensors={"z": Sensor(2, "m")},
        actuators={"a": Actuator(2, "m/s", limit=0.1)},
        estimators=[Deterministic("x", lambda a, z, dt: z + a * dt)],
        goals=[Goal("slope", slope)],
        dt=0.5,
        dtype=torch.float64,
    )

    policy = Policy(model, Sum(), ActionLaw(1.0, smoothing=0.0))
    z = torch.tensor([1.0, 2.0], dtype=torch.float64)
    action, memory = policy.predict({"z": z})
    explanation = policy.explain(memory)
    change = slope(z + 0.5 * action) - slope(z)

    assert explanation.goals["slope"].predicted_change == pytest.approx(float(change))
    assert explanation.action["a"] == pytest.approx(action.tolist())

    (candidate,) = explanation.meetings["a"].candidates
    assert (candidate.trace, candidate.rank) == ("slope → x → a", 0)
    assert candidate.strength == pytest.approx(0.5 * 10**0.5)
    assert explanation.meetings["a"].cosine is None


def test_strengths_ranks_and_cosine_are_those_of_the_step() -> None:
    ranks: set[tuple[Any, ...]] = set()

    for memory in MEMORIES[::5]:
        report = POLICY.explain(memory).meetings["x_rob"]
        gradients = memory["x_rob/gradients"]

        assert [candidate.trace for candidate in report.candidates] == [
            str(path).removesuffix(" → a") for path in traces(POLICY)
        ]
        assert [c.strength for c in report.candidates] == pytest.approx(
            gradients.norm(dim=-1).tolist()
        )

        lengths = gradients.norm(dim=-1)
        first = int(memory["x_rob/rank"][0])  # which hysteresis may keep in the lead
        second = next(i for i in lengths.argsort(descending=True).tolist() if i != first)
        cosine = float(gradients[first] @ gradients[second] / (lengths[first] * lengths[second]))
        if lengths[second] >= 1e-3:  # else nothing is left to compare with
            assert report.cosine == pytest.approx(cosine, abs=1e-9)
        held = {
            index: rank for rank, index in enumerate(memory["x_rob/rank"].tolist()) if index >= 0
        }

        assert [candidate.rank for candidate in report.candidates] == [
            held.get(index) for index in range(3)
        ]
        assert report.exploring == bool(memory["x_rob/exploring"])

        ranks.add(tuple(candidate.rank for candidate in report.candidates))

    assert len(ranks) > 1


def traces(policy: Policy) -> list[Any]:
    """The paths in the order in which their gradients meet at x_rob."""
    by_trace = {str(path).removesuffix(" → x_rob → a"): path for path in policy.model.paths()}
    return [by_trace[str(arrival)] for arrival in policy.backward_pass.arrivals["x_rob"]]


def test_exploration_is_reported_as_it_was() -> None:
    states = {POLICY.explain(memory).meetings["x_rob"].exploring for memory in MEMORIES}
    assert states == {True, False}


def test_it_reads_as_a_few_lines() -> None:
    text = str(POLICY.explain(MEMORIES[-1]))

    for word in (
        "a = (",
        "goal reach",
        "goal avoid",
        "at x_rob",
        "cosine",
        "rank 0",
        "reach → P_tar → x_rob",
        "strength",
    ):
        assert word in text

    assert len(text.splitlines()) == 1 + 2 + (1 + 3) + (1 + 1)


def test_a_row_of_a_batch_is_explained_as_alone() -> None:
    recorded = drifting(30, (2, 3))
    memory = rollout(POLICY, recorded)[-1]
    alone = rollout(
        POLICY, [{key: value[1, 2] for key, value in reading.items()} for reading in recorded]
    )[-1]
    one, other = POLICY.explain(memory, row=(1, 2)), POLICY.explain(alone)

    assert one.action["a"] == pytest.approx(other.action["a"])

    for name in ("reach", "avoid"):
        assert one.goals[name].predicted_change == pytest.approx(other.goals[name].predicted_change)

    for row in ((), 1, (0,)):
        with pytest.raises(ValueError, match=r"row=.*batch shape \(2, 3\)"):
            POLICY.explain(memory, row=row)


@pytest.mark.parametrize("rule", [Sum(), SteepestPath()], ids=["sum", "steepest"])
def test_every_rule_can_be_explained(rule: Any) -> None:
    policy = Policy(POLICY.model, rule, ActionLaw(20.0))
    report = policy.explain(rollout(policy, drifting(5))[-1])
    meeting = report.meetings["a" if isinstance(rule, SteepestPath) else "x_rob"]

    assert len(meeting.candidates) == 3
    assert all(candidate.strength >= 0 for candidate in meeting.candidates)
    assert not meeting.exploring

    if isinstance(rule, SteepestPath):
        assert {candidate.trace for candidate in meeting.candidates} == {
            str(path) for path in policy.model.paths()
        }
        leading = max(meeting.candidates, key=lambda candidate: candidate.strength)
        assert [candidate.rank for candidate in meeting.candidates].count(
            0
        ) == 1 and leading.rank == 0


def test_explaining_changes_nothing_and_needs_no_gradients_about() -> None:
    with torch.no_grad():
        before = {key: value.clone() for key, value in MEMORIES[-1].items()}
        POLICY.explain(MEMORIES[-1])
        assert all(torch.equal(MEMORIES[-1][key], value) for key, value in before.items())
