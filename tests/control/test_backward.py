"""The sweep: on random graphs, cyclic ones included, its sum is the total derivative, and paths are what Eq. 1 says."""

import itertools
from collections.abc import Callable, Sequence
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
from _inputs import Blueprint, actions, blueprints, graphs, in_motion, normal, readings, unlimited
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from torch import Tensor

from aicon_torch import (
    ActionLaw,
    Actuator,
    Estimator,
    Exploration,
    Deterministic,
    Goal,
    GraphError,
    Interconnection,
    NullspaceProjection,
    Policy,
    Sensor,
    SteepestPath,
    Sum,
    WorldModel,
    by_sign,
)
from aicon_torch.control import BackwardPass

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


@given(graphs(), st.sampled_from([(), (1,), (2, 3)]))
def test_sum_over_paths_is_the_sweep_is_the_total_derivative(blueprint: Blueprint, batch: tuple[int, ...]) -> None:
    model = build(blueprint)
    values, moved, tapes = stepped(model, batch)
    total = totals(model, values, moved)
    assert_equal_gradients(sums_over_paths(model, tapes), total)
    assert_equal_gradients(swept(unlimited(model, Sum()), model, batch), total)


@given(graphs())
def test_factors_of_a_path_are_full_jacobians(blueprint: Blueprint) -> None:
    model = build(blueprint)
    _, _, tapes = stepped(model, ())
    for path in itertools.islice(model.paths(), 30):
        torch.testing.assert_close(
            along(path, model, tapes), through_jacobians(path, model, tapes), rtol=1e-10, atol=1e-12
        )


@given(graphs(derivatives=("model", "update")))
def test_total_derivative_agrees_with_finite_differences(blueprint: Blueprint) -> None:
    model = build(blueprint)
    values, moved, _ = stepped(model, ())
    assert_equal_gradients(totals(model, values, moved), numeric_totals(model, values, moved), rtol=1e-6)


@given(graphs(), st.sampled_from([(), (3,)]))
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


@given(graphs())
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


@given(graphs())
def test_singles_are_rows_of_a_batch(blueprint: Blueprint) -> None:
    model = build(blueprint)
    policy = Policy(model, full_rule(), ActionLaw(gain=0.5))
    assert_rows_stand_alone(policy, [readings((3,), seed) for seed in range(3)], rows=(0, 2))


@given(graphs(), st.randoms(use_true_random=False))
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


@given(graphs())
def test_gradients_are_finite_and_meet_where_the_memory_says(blueprint: Blueprint) -> None:
    model = build(blueprint)
    policy = Policy(model, full_rule(), ActionLaw(gain=0.5))
    memory = rollout(policy, [readings((2,), seed) for seed in range(3)])[-1]
    assert all(value.isfinite().all() for value in memory.values())
    readers: dict[str, int] = {}
    for edges in model.edges.values():
        for edge in edges:
            readers[edge.source] = readers.get(edge.source, 0) + len(edge.labels)
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

    estimators = [Deterministic("l0", rails), Deterministic("r0", lambda a: 1.1 * a)]
    for i in range(rungs):
        estimators.append(Deterministic(f"l{i + 1}", rail(f"l{i}", f"r{i}")))
        estimators.append(Deterministic(f"r{i + 1}", rail(f"r{i}", f"l{i}")))
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
        estimators=[Deterministic("x", two_ways), Deterministic("y", lambda x: 2.0 * x)],
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
    final = BackwardPass(fork(), NullspaceProjection()).final
    assert (final["y"], final["x"]) == (False, True)


def test_arrivals_tell_where_each_gradient_comes_from() -> None:
    sweep = BackwardPass(fork(), NullspaceProjection())
    assert {str(arrival) for arrival in sweep.arrivals["y"]} == {"up", "down"}
    assert {str(arrival) for arrival in sweep.arrivals["x"]} == {"up+down → y", "side"}
    assert {arrival.goals for arrival in sweep.arrivals["x"]} == {frozenset(["up", "down"]), frozenset(["side"])}
    every_path = BackwardPass(fork(), SteepestPath())
    assert {f"{arrival} → a" for arrival in every_path.arrivals["a"]} == {str(path) for path in fork().paths()}


def test_an_edge_may_depend_on_the_sign_of_what_arrives() -> None:
    def react(a: Tensor) -> Tensor:
        return by_sign(3.0 * a, a)  # reacts three times as much to what is to be reduced

    model = WorldModel(
        sensors={"z": Sensor(1, "m")},
        actuators={"a": Actuator(2, "m")},
        estimators=[Deterministic("x", react)],
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


# --- quantities with rows


def bent(a: Tensor) -> Tensor:
    return a + 0.3 * torch.sin(2.0 * a)


class Row:
    """One row, nonlinear in both, and different for every seed."""

    def __init__(self, seed: int) -> None:
        self.scale = 1.0 + 0.3 * seed

    def __call__(self, x: Tensor, r: Tensor) -> Tensor:
        return torch.sin(self.scale * x * r) + 0.5 * (x - r) ** 2


def anchors(count: int) -> Callable[..., Tensor]:
    """Rows of points that the reading shifts."""
    points = normal(count, 2, seed=4)
    return lambda z: points + 0.1 * z.unsqueeze(-2)


def distances(*names: str, beside: str | None = None) -> Callable[..., Tensor]:
    """A cost on all rows of some quantities, each row and component at a weight of its own, and on a vector."""
    namespace: dict[str, Any] = {"normal": normal, "torch": torch}
    terms = [f"({n} * normal(*{n}.shape[-2:], seed={7 + i})).sum((-1, -2)) ** 2" for i, n in enumerate(names)]
    terms += [f"torch.cos({beside}).sum(-1)"] * (beside is not None)
    exec(f"def cost({', '.join((*names, *([beside] if beside else [])))}): return {' + '.join(terms)}", namespace)
    function: Callable[..., Tensor] = namespace["cost"]
    return function


def model_of(*estimators: Estimator, goals: Sequence[Goal]) -> WorldModel:
    return WorldModel(
        sensors={"z": Sensor(2, "m")},
        actuators={"a": Actuator(2, "m")},
        estimators=estimators,
        goals=goals,
        dtype=torch.float64,
    )


def rows_of(of: str = "r", /, **families: int) -> list[Estimator]:
    """Rowed functions of x, each with its number of rows; those with equally many read the same anchors, ``r3``."""
    placed = [Deterministic(f"{of}{count}", anchors(count)) for count in dict.fromkeys(families.values())]
    written = {
        name: Interconnection(Row(seed), inputs=["x", f"{of}{n}"]) for seed, (name, n) in enumerate(families.items())
    }
    return [*placed, *(Deterministic(name, row, each=[f"{of}{families[name]}"]) for name, row in written.items())]


def moved(policy: Policy, batch: tuple[int, ...] = ()) -> tuple[dict[str, Tensor], dict[str, Tensor]]:
    """The memory after a step away from rest, and the actions before it."""
    _, start = policy.predict(readings(batch, 1))
    start |= actions(policy.model, batch, 3)
    return policy.predict(readings(batch, 2), start)[1], start


@pytest.mark.parametrize("count", [1, 2, 5])
@pytest.mark.parametrize("batch", [(), (4,), (2, 3)], ids=str)
def test_each_row_pulls_as_if_the_other_rows_were_constants(count: int, batch: tuple[int, ...]) -> None:
    goals = [Goal("g", distances("y"))]
    model = model_of(Deterministic("x", bent), *rows_of(y=count), goals=goals)
    memory, start = moved(unlimited(model, SteepestPath()), batch)
    tapes = model.record({**{name: memory[name] for name in model.quantities}, "a": start["a"]})
    paths = list(model.paths())
    assert [str(path) for path in paths] == [f"g → y[{row}] → x → a" for row in range(count)]
    for row, path in enumerate(paths):

        def only(x: Tensor, r: Tensor, row: int = row) -> Tensor:
            value = Row(0)(x.unsqueeze(-2), r)
            return torch.where(torch.arange(count).unsqueeze(-1) == row, value, value.detach())

        alone = model_of(Deterministic("x", bent), Deterministic("r", anchors(count)), Deterministic("y", only), goals=goals)
        expected, _ = moved(unlimited(alone, Sum()), batch)
        torch.testing.assert_close(along(path, model, tapes), -expected["a"], rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("batch", [(), (3,)], ids=str)
def test_the_steepest_path_may_be_a_row(batch: tuple[int, ...]) -> None:
    model = model_of(Deterministic("x", bent), *rows_of(y=3, w=2), goals=[Goal("g", distances("y", "w", beside="x"))])
    policy = unlimited(model, SteepestPath())
    memory, start = moved(policy, batch)
    tapes = model.record({**{name: memory[name] for name in model.quantities}, "a": start["a"]})
    by_label = {str(path): along(path, model, tapes) for path in model.paths()}
    assert {f"{arrival} → a" for arrival in policy.backward_pass.arrivals["a"]} == by_label.keys()
    for index, arrival in enumerate(policy.backward_pass.arrivals["a"]):  # what is remembered stands under its label
        torch.testing.assert_close(memory["a/gradients"][..., index, :], by_label[f"{arrival} → a"])
    stack = torch.stack(list(by_label.values()), dim=-2)
    longest = stack.norm(dim=-1).argmax(-1)[..., None, None]
    torch.testing.assert_close(-memory["a"], stack.take_along_dim(longest, -2).squeeze(-2))


def added(by_row: bool = True) -> NullspaceProjection:
    """Gradients are added as they are."""
    return NullspaceProjection(None, 0.0, "none", by_row=by_row, exploration=None)


def arrived(policy: Policy, memory: dict[str, Tensor]) -> dict[frozenset[str], Tensor]:
    """The gradients at x by the last quantities that they came through."""
    labels = [frozenset(arrival.trace[-1].split("+")) for arrival in policy.backward_pass.arrivals["x"]]
    gradients = memory["x/gradients"].unbind(-2)
    assert len(set(labels)) == len(labels)
    return dict(zip(labels, gradients, strict=True))


FAMILIES: dict[str, tuple[dict[str, int], list[str]]] = {
    "one": ({"y": 3}, ["y[0]", "y[1]", "y[2]"]),
    "two of a kind": ({"y": 2, "w": 2}, ["y[0] w[0]", "y[1] w[1]"]),
    "two kinds": ({"y": 2, "w": 3}, ["y[0]", "y[1]", "w[0]", "w[1]", "w[2]"]),
    "three of a kind and another": ({"y": 2, "w": 2, "v": 1, "u": 2}, ["y[0] w[0] u[0]", "y[1] w[1] u[1]", "v[0]"]),
    "a single row of each": ({"y": 1, "w": 1}, ["y[0] w[0]"]),
}
"""Numbers of rows by quantity, and which of them are summed."""


@pytest.mark.parametrize(("families", "together"), FAMILIES.values(), ids=FAMILIES.keys())
@pytest.mark.parametrize("batch", [(), (2, 3)], ids=str)
def test_by_row_sums_what_comes_from_the_same_row(
    families: dict[str, int], together: list[str], batch: tuple[int, ...]
) -> None:
    """And what comes from elsewhere stays a candidate of its own: another goal's gradient, and another function's."""
    plain = Deterministic("n", lambda x: torch.tanh(2.0 * x))
    goals = [Goal("g", distances(*families, beside="n")), Goal("direct", distances(beside="x"))]
    model = model_of(Deterministic("x", bent), plain, *rows_of(**families), goals=goals)
    apart, joined = (unlimited(model, added(by_row)) for by_row in (False, True))
    (alone, start), (summed, _) = moved(apart, batch), moved(joined, batch)
    by_label = {next(iter(label)): gradient for label, gradient in arrived(apart, alone).items()}
    rows = {f"{name}[{row}]" for name, count in families.items() for row in range(count)}
    assert by_label.keys() == rows | {"n", "direct"}
    expected = [frozenset(labels.split()) for labels in (*together, "n", "direct")]
    found = arrived(joined, summed)
    assert found.keys() == set(expected)
    for labels in expected:
        torch.testing.assert_close(found[labels], sum(by_label[label] for label in labels))
    total = totals(model, {name: summed[name] for name in model.quantities}, {"a": start["a"]})
    for memory in (alone, summed):  # added up, it is the same gradient
        torch.testing.assert_close(memory["a"], -total["a"], rtol=1e-12, atol=1e-12)


def test_by_row_sums_two_families_apart() -> None:
    model = model_of(
        Deterministic("x", bent), *rows_of(y=3, w=3, v=2, u=2), goals=[Goal("g", distances("y", "w", "v", "u"))]
    )
    policy = unlimited(model, added())
    memory, start = moved(policy)
    assert {frozenset("yw"), frozenset("vu")} == {
        frozenset(label[0] for label in labels) for labels in arrived(policy, memory)
    }
    total = totals(model, {name: memory[name] for name in model.quantities}, {"a": start["a"]})
    torch.testing.assert_close(memory["a"], -total["a"])


def test_a_row_that_two_goals_share_is_of_both() -> None:
    model = model_of(
        Deterministic("x", bent), *rows_of(y=2, w=2), goals=[Goal("g", distances("y")), Goal("h", distances("w"))]
    )
    policy = unlimited(model, added())
    arrivals = policy.backward_pass.arrivals["x"]
    assert [arrival.goals for arrival in arrivals] == 2 * [frozenset("gh")]
    assert [{part in str(arrival) for part in ("g → y[0]", "h → w[0]")} for arrival in arrivals] == [{True}, {False}]
    memory, start = moved(policy)
    total = totals(model, {name: memory[name] for name in model.quantities}, {"a": start["a"]})
    torch.testing.assert_close(memory["a"], -total["a"])


def test_by_row_loses_nothing_where_one_candidate_is_left() -> None:
    model = model_of(Deterministic("x", bent), *rows_of(y=1, w=1), goals=[Goal("g", distances("y", "w"))])
    memory, start = moved(unlimited(model, added()))
    total = totals(model, {name: memory[name] for name in model.quantities}, {"a": start["a"]})
    torch.testing.assert_close(memory["a"], -total["a"])


def test_by_row_keeps_rows_of_unrelated_things_apart() -> None:
    """Two landmarks and two obstacles: the first landmark has nothing to do with the first obstacle."""
    model = model_of(
        Deterministic("x", bent),
        *rows_of(y=2),
        *rows_of("o", w=2),
        goals=[Goal("g", distances("y")), Goal("h", distances("w"))],
    )
    arrivals = BackwardPass(model, added()).arrivals["x"]
    assert {arrival.goals for arrival in arrivals} == {frozenset("g"), frozenset("h")}


def test_a_rowed_quantity_is_one_quantity_where_its_gradients_meet() -> None:
    """Two goals meet at y: one candidate each, over all components; what leaves comes apart into rows further on."""
    model = model_of(Deterministic("x", bent), *rows_of(y=3), goals=[Goal("g", distances("y")), Goal("h", distances("y"))])
    policy = unlimited(model, added(by_row=False))
    memory, start = moved(policy, (2,))
    assert memory["y/gradients"].shape == (2, 2, 6)
    assert [str(arrival) for arrival in policy.backward_pass.arrivals["x"]] == [f"g+h → y[{row}]" for row in range(3)]
    total = totals(model, {name: memory[name] for name in model.quantities}, {"a": start["a"]})
    torch.testing.assert_close(memory["a"], -total["a"])


def test_rows_that_meet_elsewhere_are_explained_by_row() -> None:
    model = model_of(Deterministic("x", bent), *rows_of(y=3), goals=[Goal("g", distances("y"))])
    policy = unlimited(model, NullspaceProjection(temperature=None))
    memory, _ = moved(policy)
    report = policy.explain(memory).meetings["x"]
    assert [candidate.trace for candidate in report.candidates] == [f"g → y[{row}] → x" for row in range(3)]
    lengths = memory["x/gradients"].norm(dim=-1)
    assert [candidate.strength for candidate in report.candidates] == pytest.approx(lengths.tolist())
    assert report.candidates[int(lengths.argmax())].rank == 0
