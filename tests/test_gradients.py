"""The sweep: on random graphs, cyclic ones included, its sum is the total derivative, and paths are what Eq. 1 says."""

import itertools
from collections.abc import Callable
from typing import Any

import pytest
import torch
from _asserts import (
    along,
    assert_equal_gradients,
    assert_rows_stand_alone,
    numeric_totals,
    rollout,
    sums_over_paths,
    through_jacobians,
    totals,
)
from _inputs import Blueprint, actions, blueprints, in_motion, readings, unlimited
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from torch import Tensor

from aicon_torch import (
    ActionLaw,
    Actuator,
    Exploration,
    Function,
    Goal,
    GraphError,
    NullspaceProjection,
    Policy,
    Sensor,
    SteepestPath,
    Sum,
    WorldModel,
    by_sign,
)
from aicon_torch.gradients import Sweep

MANY = 300
"""Paths beyond which a random graph is left out, to save time."""


def build(blueprint: Blueprint) -> WorldModel:
    """The model, unless feedback has cut an actuator off."""
    try:
        model = blueprint.build()
    except GraphError as error:
        assume("depends on" not in str(error))
        raise
    assume(len(model.paths()) <= MANY)
    return model


def stepped(model: WorldModel, batch: tuple[int, ...]) -> tuple[dict[str, Tensor], dict[str, Tensor], Any]:
    """Values after one more step, the actions that led there, and the tapes of the step."""
    moved = actions(model, batch, 9)
    values, tapes = model.step(in_motion(model, batch) | moved | readings(batch, 9))
    return values, moved, tapes


def swept(policy: Policy, model: WorldModel, batch: tuple[int, ...]) -> dict[str, Tensor]:
    """The gradients that a policy descends at the same values as :func:`stepped`."""
    _, memory = policy.predict(readings(batch, 1))
    memory |= in_motion(model, batch) | actions(model, batch, 9)
    _, memory = policy.predict(readings(batch, 9), memory)
    return {name: -memory[name] for name in model.actuators}


@given(blueprints(), st.sampled_from([(), (1,), (2, 3)]))
def test_sum_over_paths_is_the_sweep_is_the_total_derivative(blueprint: Blueprint, batch: tuple[int, ...]) -> None:
    model = build(blueprint)
    values, moved, tapes = stepped(model, batch)
    total = totals(model, values, moved)
    assert_equal_gradients(sums_over_paths(model, tapes), total)
    assert_equal_gradients(swept(unlimited(model, Sum()), model, batch), total)


@given(blueprints())
def test_factors_of_a_path_are_full_jacobians(blueprint: Blueprint) -> None:
    model = build(blueprint)
    _, _, tapes = stepped(model, ())
    for path in itertools.islice(model.paths(), 30):
        torch.testing.assert_close(
            along(path, model, tapes), through_jacobians(path, model, tapes), rtol=1e-10, atol=1e-12
        )


@given(blueprints(derivatives=("model", "update")))
def test_total_derivative_agrees_with_finite_differences(blueprint: Blueprint) -> None:
    model = build(blueprint)
    values, moved, _ = stepped(model, ())
    assert_equal_gradients(totals(model, values, moved), numeric_totals(model, values, moved), rtol=1e-6)


@given(blueprints(), st.sampled_from([(), (3,)]))
def test_steepest_path_is_the_longest_of_all_path_gradients(blueprint: Blueprint, batch: tuple[int, ...]) -> None:
    model = build(blueprint)
    assume(len(model.paths()) <= 60)
    _, _, tapes = stepped(model, batch)
    steepest = swept(unlimited(model, SteepestPath()), model, batch)
    for actuator in model.actuators:
        stack = torch.stack([along(p, model, tapes) for p in model.paths() if p.actuator == actuator], dim=-2)
        longest = stack.norm(dim=-1).argmax(-1, keepdim=True)
        expected = stack.take_along_dim(longest.unsqueeze(-1), -2).squeeze(-2)
        torch.testing.assert_close(steepest[actuator], expected, rtol=1e-9, atol=1e-12)


@given(blueprints())
def test_number_of_paths_is_counted_without_walking_them(blueprint: Blueprint) -> None:
    model = build(blueprint)
    paths = list(model.paths())
    assert len(model.paths()) == len(paths) == len(set(paths))
    for path in paths:
        assert path.goal in model.goals and path.actuator in model.actuators
        assert len(set(path.quantities)) == len(path.quantities)


def full_rule() -> NullspaceProjection:
    """Projection, ordering with hysteresis, and exploration at the slightest conflict, so that there is much of it."""
    return NullspaceProjection(exploration=Exploration(enter_cosine=-0.1, exit_cosine=0.0, ratio=10.0))


@given(blueprints())
def test_singles_are_rows_of_a_batch(blueprint: Blueprint) -> None:
    model = build(blueprint)
    policy = Policy(model, full_rule(), ActionLaw(gain=0.5))
    assert_rows_stand_alone(policy, [readings((3,), seed) for seed in range(3)], rows=(0, 2))


@given(blueprints(), st.randoms(use_true_random=False))
def test_order_of_the_goals_does_not_matter(blueprint: Blueprint, random: Any) -> None:
    model = build(blueprint)
    names = list(model.goals)
    random.shuffle(names)
    other = blueprint.build(goals=names)
    recorded = [readings((), seed) for seed in range(4)]
    for first, second in zip(
        rollout(Policy(model, full_rule(), ActionLaw(0.5)), recorded),
        rollout(Policy(other, full_rule(), ActionLaw(0.5)), recorded),
        strict=True,
    ):
        for actuator in model.actuators:
            torch.testing.assert_close(first[actuator], second[actuator], rtol=1e-9, atol=1e-12)


@given(blueprints())
def test_gradients_are_finite_and_meet_where_the_memory_says(blueprint: Blueprint) -> None:
    model = build(blueprint)
    policy = Policy(model, full_rule(), ActionLaw(gain=0.5))
    memory = rollout(policy, [readings((2,), seed) for seed in range(3)])[-1]
    assert all(value.isfinite().all() for value in memory.values())
    readers: dict[str, int] = {}
    for edges in model.edges.values():
        for edge in edges:
            readers[edge.source] = readers.get(edge.source, 0) + 1
    assert {key.split("/")[0] for key in memory if key.endswith("/gradients")} == {
        q for q, n in readers.items() if n > 1
    }


# --- cost: edges, not paths


def ladder(rungs: int) -> WorldModel:
    """Two rails; every rung crosses over, so that each doubles the number of paths."""

    def rail(left: str, right: str) -> Callable[..., Tensor]:
        namespace: dict[str, Any] = {"torch": torch}
        exec(f"def f({left}, {right}): return torch.sin({left}) + 0.5 * {right}", namespace)
        function: Callable[..., Tensor] = namespace["f"]
        return function

    def rails(a: Tensor) -> Tensor:
        return 0.9 * a

    estimators = [Function("l0", rails), Function("r0", lambda a: 1.1 * a)]
    for i in range(rungs):
        estimators.append(Function(f"l{i + 1}", rail(f"l{i}", f"r{i}")))
        estimators.append(Function(f"r{i + 1}", rail(f"r{i}", f"l{i}")))
    namespace: dict[str, Any] = {}
    exec(f"def cost(l{rungs}, r{rungs}): return (l{rungs} * r{rungs}).sum(-1)", namespace)
    return WorldModel(
        sensors={"z": Sensor(1, "m")},
        actuators={"a": Actuator(2, "m")},
        estimators=estimators,
        goals=[Goal("g", namespace["cost"])],
        dtype=torch.float64,
    )


@pytest.mark.parametrize("rule", [Sum(), NullspaceProjection(exploration=Exploration())], ids=["sum", "nullspace"])
def test_a_sweep_costs_edges_though_paths_double_with_every_rung(
    rule: Sum | NullspaceProjection, monkeypatch: pytest.MonkeyPatch
) -> None:
    pulls: dict[int, int] = {}
    leaves: dict[int, int] = {}
    original = torch.autograd.grad
    for rungs in (6, 12, 24):
        model = ladder(rungs)
        assert len(model.paths()) == 2 ** (rungs + 1)
        policy = Policy(model, rule, ActionLaw(1.0))
        counted: list[int] = []

        def count(outputs: Any, inputs: Any, *args: Any, counted: list[int] = counted, **kwargs: Any) -> Any:
            counted.append(len(inputs) if isinstance(inputs, list | tuple) else 1)
            return original(outputs, inputs, *args, **kwargs)

        with monkeypatch.context() as patch:
            patch.setattr(torch.autograd, "grad", count)
            policy.predict({"z": torch.zeros(1, dtype=torch.float64)})
        pulls[rungs], leaves[rungs] = len(counted), sum(counted)
    edges = {rungs: 4 * rungs + 4 for rungs in pulls}
    assert leaves == edges
    assert all(pulls[rungs] <= edges[rungs] for rungs in pulls)
    assert pulls[24] - pulls[12] == 2 * (pulls[12] - pulls[6])


# --- where gradients meet


def two_ways(a: Tensor) -> Tensor:
    return a


def fork() -> WorldModel:
    """Two goals meet at y and a third joins them at x."""
    return WorldModel(
        sensors={"z": Sensor(1, "m")},
        actuators={"a": Actuator(2, "m")},
        estimators=[Function("x", two_ways), Function("y", lambda x: 2.0 * x)],
        goals=[
            Goal("up", lambda y: y[..., 1]),
            Goal("down", lambda y: 0.3 * y[..., 0] - 0.2 * y[..., 1]),
            Goal("side", lambda x: 0.1 * x[..., 0]),
        ],
        dtype=torch.float64,
    )


def test_gradients_are_resolved_at_every_quantity_where_they_meet() -> None:
    model = fork()
    rule = NullspaceProjection(temperature=None, exploration=None)
    _, memory = unlimited(model, rule).predict({"z": torch.zeros(1, dtype=torch.float64)})
    expected = {"y": [[0.0, 1.0], [0.3, -0.2]], "x": [[0.6, 2.0], [0.1, 0.0]]}  # at y 0.3, 1.0 leaves, times two
    for name, stack in expected.items():
        arrived = torch.tensor(sorted(memory[f"{name}/gradients"].tolist()), dtype=torch.float64)
        torch.testing.assert_close(arrived, torch.tensor(sorted(stack), dtype=torch.float64))
    assert "a/gradients" not in memory
    assert memory["a/gradient"].tolist() == (-memory["a"]).tolist()


def test_it_knows_where_gradients_meet_for_the_last_time() -> None:
    final = Sweep(fork(), NullspaceProjection()).final
    assert (final["y"], final["x"]) == (False, True)


def test_arrivals_tell_where_each_gradient_comes_from() -> None:
    sweep = Sweep(fork(), NullspaceProjection())
    assert {str(arrival) for arrival in sweep.arrivals["y"]} == {"up", "down"}
    assert {str(arrival) for arrival in sweep.arrivals["x"]} == {"up+down → y", "side"}
    assert {arrival.goals for arrival in sweep.arrivals["x"]} == {frozenset(["up", "down"]), frozenset(["side"])}
    every_path = Sweep(fork(), SteepestPath())
    assert {f"{arrival} → a" for arrival in every_path.arrivals["a"]} == {str(path) for path in fork().paths()}


def test_an_edge_may_depend_on_the_sign_of_what_arrives() -> None:
    def react(a: Tensor) -> Tensor:
        return by_sign(3.0 * a, a)  # reacts three times as much to what is to be reduced

    model = WorldModel(
        sensors={"z": Sensor(1, "m")},
        actuators={"a": Actuator(2, "m")},
        estimators=[Function("x", react)],
        goals=[Goal("g", lambda x: x[..., 0] - x[..., 1])],
        dtype=torch.float64,
    )
    _, memory = unlimited(model, Sum()).predict({"z": torch.zeros(1, dtype=torch.float64)})
    assert memory["a"].tolist() == [-3.0, 1.0]


def test_switched_off_goals_pull_nothing() -> None:
    model = fork()
    policy = unlimited(model, Sum())
    observation = {"z": torch.zeros(1, dtype=torch.float64)}
    _, memory = policy.predict(observation)
    for off, expected in (({"up": False}, [-0.7, 0.4]), ({"up": False, "down": 0.0}, [-0.1, 0.0])):
        action, _ = policy.predict(observation, policy.switch(memory, **off))
        torch.testing.assert_close(action, torch.tensor(expected, dtype=torch.float64))


@settings(max_examples=10)
@given(blueprints())
def test_a_factor_scales_the_gradient_of_its_goal(blueprint: Blueprint) -> None:
    model = build(blueprint)
    policy = unlimited(model, Sum())
    _, memory = policy.predict(readings((), 0))
    whole, _ = policy.predict(readings((), 1), memory)
    parts = []
    for name in model.goals:
        others = {goal: goal == name for goal in model.goals}
        parts.append(policy.predict(readings((), 1), policy.switch(memory, **others))[0])
    for actuator in model.actuators:
        pick = (lambda action, a=actuator: action[a]) if len(model.actuators) > 1 else (lambda action: action)
        torch.testing.assert_close(pick(whole), sum(pick(part) for part in parts), rtol=1e-9, atol=1e-12)
