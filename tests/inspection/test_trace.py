"""The trace of a step: batched and typed, and the same as what the memory holds."""

import pytest
import torch
from _asserts import rollout
from _inputs import (
    Blueprint,
    built,
    drifting,
    graphs,
    lengths,
    navigation,
    navigation_in_text,
    readings,
    unlimited,
)
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

RULES: dict[str, Resolution] = {
    "sum": Sum(),
    "steepest": SteepestPath(),
    "as shipped": NullspaceProjection(),
    "as in the paper": NullspaceProjection.as_in_paper(),
}

every_rule = pytest.mark.parametrize("rule", RULES.values(), ids=RULES.keys())


def ways_apart() -> WorldModel:
    """Two goals that oppose each other along the first axis while the reading is 1."""

    def toward(x: Tensor) -> Tensor:
        return x[..., 0]

    def against(x: Tensor, z: Tensor) -> Tensor:
        return -0.9 * z[..., 0] * x[..., 0] + (1 - z[..., 0]) * x[..., 1]

    return WorldModel(
        sensors={"z": Sensor(1, "1")},
        actuators={"a": Actuator(2, "m")},
        estimators=[Deterministic("x", lambda a: 1.0 * a)],
        goals=[Goal("toward", toward), Goal("against", against)],
        dtype=torch.float64,
    )


# --- what the memory holds


def test_values_and_costs_are_those_of_the_step() -> None:
    policy = navigation()
    memory = rollout(policy, drifting(10, (3,)))[-1]
    trace = policy.trace(memory)

    assert trace.values.keys() == policy.model.quantities.keys()
    for name, value in trace.values.items():
        assert torch.equal(value, memory[name])

    assert trace.costs.keys() == policy.model.goals.keys()
    for name, goal in policy.model.goals.items():
        expected = goal(policy.model.values(memory))
        assert trace.costs[name].shape == (3,)
        torch.testing.assert_close(trace.costs[name], expected)


def test_gradients_ranks_and_conflicts_are_those_of_the_memory() -> None:
    policy = navigation()

    for memory in rollout(policy, drifting(20, (3,))):
        there = policy.trace(memory).quantities["x_rob"]
        assert torch.equal(there.gradients, memory["x_rob/gradients"])
        assert torch.equal(there.exploring, memory["x_rob/exploring"])
        assert torch.equal(there.cosine, memory["x_rob/cosine"])

        torch.testing.assert_close(there.magnitudes, lengths(there.gradients))
        torch.testing.assert_close(there.weights, policy.resolution.weigh(there.magnitudes))

        for row, held in enumerate(memory["x_rob/rank"].tolist()):
            expected = [held.index(i) if i in held else -1 for i in range(3)]
            assert there.ranks[row].tolist() == expected
            assert int(there.dominant[row]) == held[0]


def test_a_leading_path_goes_from_a_goal_to_the_actuator_over_what_dominates_each_meeting() -> None:
    policy = navigation()
    complete = {tuple(str(path).split(" → ")) for path in policy.model.paths()}

    for memory in rollout(policy, drifting(10, (3,))):
        trace = policy.trace(memory)
        there = trace.quantities["x_rob"]
        for row in range(3):
            led = trace.leading_path("a", (row,))
            assert led in complete
            assert led[:-1] == there.paths[int(there.dominant[row])]


def test_the_cosine_is_that_of_the_dominant_gradient_and_its_opponent() -> None:
    policy = navigation_in_text()
    explored = 0

    for memory in rollout(policy, drifting(30)):
        there = policy.trace(memory).quantities["x_rob"]
        dominant, opponent = int(there.dominant), int(there.opponent)
        assert dominant != opponent
        explored += int(there.exploring)

        if there.magnitudes[opponent] > 1e-9:  # else it has no direction
            pair = there.gradients[[dominant, opponent]]
            expected = torch.cosine_similarity(pair[0], pair[1], dim=0)
            torch.testing.assert_close(there.cosine, expected)

    assert explored


@pytest.mark.parametrize(("preset", "quantity"), [("potential_field", "x_rob"), ("steepest", "a")])
def test_without_exploration_the_opponent_is_the_second_strongest(
    preset: str, quantity: str
) -> None:
    policy = navigation(preset)
    memory = rollout(policy, drifting(10, (3,)))[-1]
    there = policy.trace(memory).quantities[quantity]

    first, second, _ = there.magnitudes.argsort(descending=True).unbind(-1)
    assert torch.equal(there.dominant, first)
    assert torch.equal(there.opponent, second)

    pair = there.gradients.take_along_dim(torch.stack((first, second), dim=-1)[..., None], dim=-2)
    torch.testing.assert_close(there.cosine, torch.cosine_similarity(*pair.unbind(-2), dim=-1))


@every_rule
@given(blueprint=graphs())
def test_there_is_a_trace_wherever_gradients_met_and_for_every_actuator(
    rule: Resolution, blueprint: Blueprint
) -> None:
    model = built(blueprint)
    policy = unlimited(model, rule)
    memory = rollout(policy, [readings((2,), seed) for seed in range(2)])[-1]
    quantities = policy.trace(memory).quantities

    suffix = "/gradients"
    met = {key.removesuffix(suffix) for key in memory if key.endswith(suffix)}
    assert quantities.keys() == met | model.actuators.keys()

    for name, there in quantities.items():
        count, size = len(there.paths), model.quantities[name].size
        assert there.name == name
        assert there.gradients.shape == (2, count, size)
        assert there.magnitudes.shape == there.weights.shape == there.ranks.shape == (2, count)
        for field in (there.dominant, there.opponent, there.cosine, there.exploring):
            assert field.shape == (2,)


# --- paths and goals


@every_rule
@given(blueprint=graphs())
def test_paths_lead_from_goals_to_the_quantity(rule: Resolution, blueprint: Blueprint) -> None:
    model = built(blueprint)
    policy = unlimited(model, rule)
    _, memory = policy.predict(readings((), 0))

    for name, there in policy.trace(memory).quantities.items():
        assert len(there.paths) == len(there.labels) == len(there.goals)
        for path, label, goals in zip(there.paths, there.labels, there.goals, strict=True):
            assert path[-1] == name and label == " → ".join(path)
            assert goals and goals == tuple(goal for goal in model.goals if goal in goals)


def test_labels_of_the_navigation_are_the_paper_s_three_paths() -> None:
    policy = navigation()
    _, memory = policy.predict(drifting(1)[0])
    there = policy.trace(memory).quantities["x_rob"]

    expected = {"reach → p_tar → x_rob", "reach → P_tar → x_rob", "avoid → x_obs → x_rob"}
    assert set(there.labels) == expected
    for path, goals in zip(there.paths, there.goals, strict=True):
        assert goals == (path[0],)


@pytest.mark.parametrize("conflicting", [True, False])
def test_goals_in_conflict_are_named_while_exploring(conflicting: bool) -> None:
    policy = Policy(ways_apart(), NullspaceProjection(), DirectDescent(1.0))
    reading = torch.full((1,), float(conflicting), dtype=torch.float64)
    _, memory = policy.predict({"z": reading})

    there = policy.trace(memory).quantities["x"]
    assert bool(there.exploring) == conflicting
    assert there.goals_in_conflict() == (("toward", "against") if conflicting else None)


def test_goals_in_conflict_are_of_each_row() -> None:
    policy = Policy(ways_apart(), NullspaceProjection(), DirectDescent(1.0))
    z = torch.tensor([[[1.0], [0.0], [1.0]], [[0.0], [0.0], [1.0]]], dtype=torch.float64)
    _, memory = policy.predict({"z": z})

    there = policy.trace(memory).quantities["x"]
    for row in torch.cartesian_prod(torch.arange(2), torch.arange(3)).tolist():
        in_conflict = there.goals_in_conflict(tuple(row)) is not None
        assert in_conflict == bool(z[tuple(row)])


@every_rule
def test_where_nothing_explores_there_is_no_conflict(rule: Resolution) -> None:
    policy = Policy(ways_apart(), rule, DirectDescent(1.0))
    _, memory = policy.predict({"z": torch.zeros(1, dtype=torch.float64)})

    for there in policy.trace(memory).quantities.values():
        assert there.goals_in_conflict() is None


def test_a_single_gradient_leads_and_has_no_opponent() -> None:
    policy = navigation()
    memory = rollout(policy, drifting(3, (2,)))[-1]
    there = policy.trace(memory).quantities["a"]

    assert torch.equal(there.gradients, memory["a/gradient"].unsqueeze(-2))
    assert there.ranks.tolist() == [[0], [0]]
    assert there.dominant.tolist() == [0, 0]
    assert there.opponent.tolist() == [-1, -1]
    assert not there.exploring.any()


def test_tracing_changes_nothing_and_carries_no_graph() -> None:
    policy = navigation()
    memory = rollout(policy, drifting(5, (2,)))[-1]
    before = {key: value.clone() for key, value in memory.items()}
    trace = policy.trace(memory)

    assert all(torch.equal(memory[key], value) for key, value in before.items())
    assert not any(cost.requires_grad for cost in trace.costs.values())
    assert not any(value.requires_grad for value in trace.values.values())
