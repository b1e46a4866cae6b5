"""Explanations: what a step decided, in numbers that can be checked."""

import functools
from typing import Any

import numpy as np
import pytest
import torch
from _asserts import numeric_totals, rollout
from _inputs import Blueprint, blueprints, built, drifting, lengths, navigation_in_text, readings
from _inputs.tracking import tracking_model
from hypothesis import given
from torch import Tensor

from aicon_torch import (
    Actuator,
    Deterministic,
    DirectDescent,
    Goal,
    NullspaceProjection,
    Policy,
    Resolution,
    Sensor,
    SteepestPath,
    Sum,
    WorldModel,
)


@functools.cache
def memories() -> tuple[dict[str, Tensor], ...]:
    """Memories of some steps, among them such that explore."""
    return tuple(rollout(navigation_in_text(), drifting(30)))


# --- what the action does to the goals


@given(blueprints(derivatives=("model", "update")))
def test_the_predicted_change_is_the_slope_along_the_action(blueprint: Blueprint) -> None:
    """By finite differences of each goal, on random graphs."""
    model = built(blueprint)
    policy = Policy(model, NullspaceProjection(), DirectDescent(0.5))
    memory = rollout(policy, [readings((), seed) for seed in range(3)])[-1]
    action = {name: memory[name] for name in model.actuators}

    for name, report in policy.explain(memory).goals.items():
        cost = model.goals[name](model.values(memory))
        assert report.cost == pytest.approx(float(cost))

        slopes = numeric_totals(model, memory, action, goals=[name])
        change = sum(float(slopes[actuator] @ action[actuator]) for actuator in action)
        assert report.predicted_change == pytest.approx(change, rel=1e-5, abs=1e-7)


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
    policy = Policy(model, Sum(), DirectDescent(1.0, smoothing=0.0))

    z = torch.tensor([1.0, 2.0], dtype=torch.float64)
    action, memory = policy.predict({"z": z})
    explanation = policy.explain(memory)
    assert explanation.action["a"] == pytest.approx(action.tolist())

    change = slope(z + 0.5 * action) - slope(z)
    assert explanation.goals["slope"].predicted_change == pytest.approx(float(change))

    (candidate,) = explanation.quantities["a"].candidates
    assert (candidate.path, candidate.rank) == ("slope → x → a", 0)
    assert candidate.magnitude == pytest.approx(0.5 * 10**0.5)
    assert explanation.quantities["a"].cosine is None


# --- what happened where gradients met


def test_magnitudes_ranks_and_cosine_are_those_of_the_step() -> None:
    policy = navigation_in_text()
    complete = {str(path).removesuffix(" → a") for path in policy.model.paths()}
    ranks: set[tuple[int | None, ...]] = set()

    for memory in memories()[::2]:
        report = policy.explain(memory).quantities["x_rob"]
        gradients = memory["x_rob/gradients"]
        norms = lengths(gradients)
        assert {candidate.path for candidate in report.candidates} == complete
        magnitudes = [candidate.magnitude for candidate in report.candidates]
        assert magnitudes == pytest.approx(norms.tolist())

        # Hysteresis may keep one in the lead that is not the strongest.
        held = memory["x_rob/rank"].tolist()
        first = held[0]
        second = next(i for i in norms.argsort(descending=True).tolist() if i != first)
        if norms[second] >= 1e-3:  # else nothing is left to compare with
            cosine = gradients[first] @ gradients[second] / (norms[first] * norms[second])
            assert report.cosine == pytest.approx(float(cosine), abs=1e-9)

        found = tuple(candidate.rank for candidate in report.candidates)
        assert found == tuple(held.index(i) if i in held else None for i in range(3))
        assert report.exploring == bool(memory["x_rob/exploring"])
        ranks.add(found)

    assert len(ranks) > 1


def test_exploration_is_reported_as_it_was() -> None:
    policy = navigation_in_text()
    states = {policy.explain(memory).quantities["x_rob"].exploring for memory in memories()}
    assert states == {True, False}


def test_it_reads_as_a_few_lines() -> None:
    text = str(navigation_in_text().explain(memories()[-1]))
    assert len(text.splitlines()) == 1 + 2 + (1 + 3) + (1 + 1)

    words = ("a = (", "goal reach", "goal avoid", "at x_rob", "cosine", "rank 0", "magnitude")
    for word in (*words, "reach → P_tar → x_rob"):
        assert word in text


def test_a_row_of_a_batch_is_explained_as_alone() -> None:
    policy, recorded = navigation_in_text(), drifting(10, (2, 3))
    memory = rollout(policy, recorded)[-1]
    row = [{key: value[1, 2] for key, value in reading.items()} for reading in recorded]
    alone = rollout(policy, row)[-1]

    found, expected = policy.explain(memory, row=(1, 2)), policy.explain(alone)
    assert found.action["a"] == pytest.approx(expected.action["a"])
    for name, goal in expected.goals.items():
        assert found.goals[name].predicted_change == pytest.approx(goal.predicted_change)


@pytest.mark.parametrize(
    ("sensor", "told"),
    [
        ({"rate_limit": 2.0}, "the last is 0.10 s old, and what came since was refused"),
        ({"range": (-1.0, 3.0)}, "none ever within range=(-1.0, 3.0)"),
        ({"is_possible": lambda z: z[..., 0] < 3.0}, "none ever that is_possible allows"),
    ],
    ids=["jumped", "beyond the range", "impossible"],
)
def test_a_reading_that_was_refused_is_not_said_never_to_have_come(
    sensor: dict[str, Any], told: str
) -> None:
    model = tracking_model(
        sensors={"z": Sensor(2, "m", **sensor)}, actuators={"a": Actuator(2, "m/s", limit=1.0)}
    )
    policy, memory = Policy(model), None
    for place in [0.0] * ("rate_limit" in sensor) + [9.0]:
        _, memory = policy.predict({"z": np.full(2, place)}, memory)
    assert memory is not None and not memory["z"].any()
    assert policy.explain(memory).alerts[0].startswith(f"no reading of 'z': {told}")


@pytest.mark.parametrize("row", [(), 1, (0,), True, None, [1], (0, True), np.array([1])], ids=str)
def test_a_row_that_is_none_is_named(row: Any) -> None:
    memory = rollout(navigation_in_text(), drifting(1, (2, 3)))[-1]
    with pytest.raises(ValueError, match=r"row=.*batch shape \(2, 3\)"):
        navigation_in_text().explain(memory, row=row)


@pytest.mark.parametrize("row", [torch.tensor([1]), torch.tensor(True), (torch.tensor([1]),)])
def test_a_row_is_a_number_and_no_array_of_one(row: Any) -> None:
    memory = rollout(navigation_in_text(), drifting(1, (3,)))[-1]
    with pytest.raises(ValueError, match=r"row=.*batch shape \(3,\)"):
        navigation_in_text().explain(memory, row=row)


@pytest.mark.parametrize("row", [0, 5, (0, 0)], ids=str)
def test_one_robot_has_no_rows(row: Any) -> None:
    memory = rollout(navigation_in_text(), drifting(1))[-1]
    with pytest.raises(ValueError, match=r"row=.*batch shape \(\)"):
        navigation_in_text().explain(memory, row=row)


@pytest.mark.parametrize(
    ("rule", "quantity"), [(Sum(), "x_rob"), (SteepestPath(), "a")], ids=["sum", "steepest"]
)
def test_every_rule_can_be_explained(rule: Resolution, quantity: str) -> None:
    policy = Policy(navigation_in_text().model, rule, DirectDescent(20.0))
    report = policy.explain(rollout(policy, drifting(5))[-1]).quantities[quantity]

    assert len(report.candidates) == 3
    assert all(candidate.magnitude >= 0 for candidate in report.candidates)
    assert not report.exploring


def test_the_steepest_path_is_the_one_of_rank_0() -> None:
    policy = Policy(navigation_in_text().model, SteepestPath(), DirectDescent(20.0))
    candidates = policy.explain(rollout(policy, drifting(5))[-1]).quantities["a"].candidates

    expected = {str(path) for path in policy.model.paths()}
    assert {candidate.path for candidate in candidates} == expected

    leading = max(candidates, key=lambda candidate: candidate.magnitude)
    assert [candidate for candidate in candidates if candidate.rank == 0] == [leading]


def test_explaining_changes_nothing_and_needs_no_gradients_about() -> None:
    memory = memories()[-1]
    before = {key: value.clone() for key, value in memory.items()}

    with torch.no_grad():
        navigation_in_text().explain(memory)

    assert all(torch.equal(memory[key], value) for key, value in before.items())
