"""World models: validated at construction, ordered, stepped, drawn."""

from collections.abc import Callable
from typing import Any

import pytest
import torch
from _asserts import totals
from _inputs import Blueprint, actions, blueprints, graphs, in_motion, normal, readings
from hypothesis import assume, given
from hypothesis import strategies as st
from torch import Tensor

from aicon_torch import (
    EKF,
    ActionLaw,
    Actuator,
    Affine,
    Estimator,
    Deterministic,
    Goal,
    GraphError,
    Interconnection,
    KalmanFilter,
    Measurement,
    Policy,
    Sensor,
    Sum,
    WorldModel,
)


def move(a: Tensor, dt: float) -> Tensor:
    return a * dt


def approach(p: Tensor, x: Tensor) -> Tensor:
    return p - x


def match(p: Tensor, z: Tensor) -> Tensor:
    return p - z


def near(p: Tensor) -> Tensor:
    return (p**2).sum(-1)


def tracked(**options: Any) -> EKF:
    settings: Any = {"noise": 0.1, "initial": ((1.0, 2.0), 1.0), "correct": [Measurement(match, 0.1, size=2)]} | options
    return EKF("p", "P", **({"predict": approach} | settings))


def model(*estimators: Estimator, goals: Any = None, **options: Any) -> WorldModel:
    settings: Any = {
        "sensors": {"z": Sensor(2, "m")},
        "actuators": {"a": Actuator(2, "m/s")},
        "estimators": estimators or [Deterministic("x", move), tracked()],
        "goals": [Goal("near", near)] if goals is None else goals,
        "dt": 0.1,
        "dtype": torch.float64,
    }
    return WorldModel(**(settings | options))


# --- errors at construction, each with its culprit


def circle_f(x: Tensor, y: Tensor) -> Tensor:
    return x + y


def misspelt(p: Tensor, speed: Tensor) -> Tensor:
    return p - speed


def rows_first(a: Tensor) -> Tensor:
    return torch.stack((-a[1], a[0]))


def unpacked(a: Tensor) -> Tensor:
    right, up = a
    return torch.stack((-up, right))


def scalar(a: Tensor) -> Tensor:
    return a.norm(dim=-1)


def summed_over_everything(a: Tensor) -> Tensor:
    return a.sum()


def row(x: Tensor, corners: Tensor) -> Tensor:
    return x * corners


def both(x: Tensor, corners: Tensor, four: Tensor) -> Tensor:
    return x * corners + four


def read_whole(w: Tensor, corners: Tensor) -> Tensor:
    return w * corners


def slower(a: Tensor) -> Tensor:
    return 0.5 * a


def corner(z: Tensor) -> Tensor:
    return torch.stack((z, 2 * z, 3 * z), dim=-2)


MOVE, TRACK, CORNERS = Deterministic("x", move), tracked(), Deterministic("corners", corner)
FOUR = Deterministic("four", lambda z: torch.stack(4 * [z], dim=-2))


def far(y: Tensor) -> Tensor:
    return (y**2).sum((-1, -2))


BAD: dict[str, tuple[Callable[[], Any], str]] = {
    "misspelt in a function": (
        lambda: model(Deterministic("x", lambda aa: aa), TRACK),
        r"'x' reads 'aa'.*Known: 'z', 'a', 'x', 'p', 'P', 'dt'",
    ),
    "misspelt in a filter": (lambda: model(MOVE, tracked(predict=misspelt)), r"'p' reads 'speed'.*'z', 'a', 'x'"),
    "misspelt in a measurement": (
        lambda: model(MOVE, tracked(correct=[Measurement(lambda p, z_tar: p - z_tar, 0.1, size=2)])),
        r"'p' reads 'z_tar'.*'z', 'a'",
    ),
    "misspelt covariance of a partner": (
        lambda: model(MOVE, tracked(correct=[Measurement(lambda p, x: p - x, 0.1, uncertain={"x": "P_x"}, size=2)])),
        r"'p' reads 'P_x'",
    ),
    "misspelt in a goal": (lambda: model(goals=[Goal("near", lambda q: q.sum(-1))]), r"'near' reads 'q'.*'p', 'P'"),
    "a name twice": (lambda: model(MOVE, Deterministic("x", move), TRACK), r"'x' is declared 2 times"),
    "a sensor's name for an estimate": (lambda: model(MOVE, TRACK, Deterministic("z", move)), r"'z' is declared 2 times"),
    "a goal twice": (lambda: model(goals=[Goal("near", near), Goal("near", near)]), r"'near' is declared 2 times"),
    "the time step's name": (lambda: model(MOVE, TRACK, Deterministic("dt", lambda a: a)), r"'dt' is taken"),
    "a name of the memory": (lambda: model(goals=[Goal("near/by", near)]), r"'near/by' is taken"),
    "a flag's name": (
        lambda: model(sensors={"z": Sensor(2, "m"), "z.present": Sensor(1, "1")}),
        r"'z.present' is taken",
    ),
    "a type without fractions": (lambda: model(dtype=torch.int64), r"torch.int64.*floating-point"),
    "no goals": (lambda: model(goals=[]), "at least one goal"),
    "no actuators": (lambda: model(actuators={}), "at least one actuator"),
    "no sensors": (lambda: model(sensors={}), "at least one sensor"),
    "shapes that do not match": (
        lambda: model(Deterministic("x", Affine(a=torch.ones(3, 5))), TRACK),
        r"'x' cannot be evaluated",
    ),
    "a prediction of another size": (
        lambda: model(MOVE, tracked(predict=lambda p, x: torch.cat((p, x), -1), correct=[])),
        r"'p'|'P'",
    ),
    "rows before the batch": (lambda: model(Deterministic("x", rows_first), TRACK), r"'x'"),
    "components unpacked from the batch": (lambda: model(Deterministic("x", unpacked), TRACK), r"'x'"),
    "a quantity without components": (
        lambda: model(Deterministic("x", scalar), goals=[Goal("g", lambda x: x)]),
        r"'x'.*\(n,\)",
    ),
    "a function that sums over the batch": (
        lambda: model(Deterministic("x", summed_over_everything), goals=[Goal("g", lambda x: x)]),
        r"'x' has shape \(\)",
    ),
    "a cost with components": (lambda: model(goals=[Goal("near", lambda p: p)]), r"Goal 'near'"),
    "a cost summed over the batch": (lambda: model(goals=[Goal("near", lambda p: p.sum())]), r"Goal 'near'"),
    "a cost that cannot be evaluated": (lambda: model(goals=[Goal("near", lambda p, z: p @ z)]), r"'near'"),
    "a residual of another size": (
        lambda: model(MOVE, tracked(correct=[Measurement(match, 0.1)])),
        r"measurement of 'p'.*'p', 'z'.*2 components; expected size=1",
    ),
    "a wrong Jacobian": (
        lambda: model(MOVE, tracked(predict=Interconnection(approach, p=lambda p: 2 * torch.eye(2, dtype=p.dtype)))),
        r"Jacobian of .*approach.* by 'p' is not its derivative",
    ),
    "functions in a circle": (
        lambda: model(Deterministic("x", lambda y: y), Deterministic("y", lambda x: x), goals=[Goal("g", lambda x: x.sum(-1))]),
        r"circle: (x → y → x|y → x → y)",
    ),
    "a goal that no actuator moves": (
        lambda: model(goals=[Goal("near", near), Goal("idle", lambda z: z.sum(-1))]),
        r"Goal 'idle' depends on no actuator. It reads 'z'",
    ),
    "rows of what is not read": (
        lambda: model(MOVE, Deterministic("y", row, each=["r"])),
        r"Deterministic 'y': each='r', but it reads 'x', 'corners'",
    ),
    "rows of different number": (
        lambda: model(MOVE, CORNERS, FOUR, TRACK, Deterministic("y", both, each=["corners", "four"])),
        r"'y' cannot be evaluated",
    ),
    "rows of different number, one of them not announced": (
        lambda: model(MOVE, CORNERS, FOUR, TRACK, Deterministic("y", both, each=["corners"])),
        r"'y' cannot be evaluated",
    ),
    "rows that are read as a vector": (
        lambda: model(MOVE, CORNERS, TRACK, Deterministic("y", row)),
        r"'y' cannot be evaluated",
    ),
    "rows of a plain vector": (
        lambda: model(MOVE, TRACK, Deterministic("y", lambda x, z: x * z, each=["z"])),
        r"'y' reads 'z' of shape \(2,\)",
    ),
    "rows on a path that are not announced": (
        lambda: model(
            MOVE, CORNERS, TRACK, Deterministic("w", row, each=["corners"]), Deterministic("y", read_whole, each=["corners"])
        ),
        r"'y' reads 'w' of shape \(3, 2\); expected \(n,\), as each= does not name it",
    ),
    "rows beside a matrix": (
        lambda: model(MOVE, CORNERS, TRACK, Deterministic("y", lambda x, corners, P: x * corners, each=["corners"])),
        r"'y' reads 'P' of shape \(2, 2\)",
    ),
    "a constraint of another size": (
        lambda: model(actuators={"a": Actuator(2, "m/s", constraints=[slower, lambda a: a[..., :1]])}),
        r"of actuator 'a' returns shape \(7, 5, 1\)",
    ),
    "a constraint that is no tensor": (
        lambda: model(actuators={"a": Actuator(2, "m/s", constraints=[lambda a: 0.0])}),
        "of actuator 'a' cannot be evaluated",
    ),
    "a constraint that sums over the batch": (
        lambda: model(actuators={"a": Actuator(2, "m/s", constraints=[lambda a: a.sum()])}),
        r"of actuator 'a' returns shape \(\)",
    ),
    "a constraint that cannot be evaluated": (
        lambda: model(actuators={"a": Actuator(2, "m/s", constraints=[lambda a, P: a + P[..., :1]])}),
        "of actuator 'a' cannot be evaluated",
    ),
    "a constraint that is no function": (
        lambda: model(actuators={"a": Actuator(2, "m/s", constraints=[0.5])}),
        "Actuator 'a': constraints",
    ),
    "a command that is no function": (lambda: model(actuators={"a": Actuator(2, "m/s", command=0.5)}), "Actuator 'a'"),
    "a command that leaves no batch free": (
        lambda: model(actuators={"a": Actuator(2, "m/s", command=lambda a: torch.zeros(2))}),
        r"of actuator 'a' returns shape \(2,\)",
    ),
    "a misspelt constraint": (
        lambda: model(actuators={"a": Actuator(2, "m/s", constraints=[slower, lambda aa: aa])}),
        r"of actuator 'a' reads 'aa', which is not in the graph. Known: 'z', 'a', 'x', 'p', 'P', 'dt'",
    ),
    "a misspelt command": (
        lambda: model(actuators={"a": Actuator(2, "m/s", command=lambda a, x_rob: a + x_rob)}),
        r"of actuator 'a' reads 'x_rob', which is not in the graph. Known: 'z', 'a', 'x', 'p', 'P', 'dt'",
    ),
    "a constraint on a cost": (
        lambda: model(actuators={"a": Actuator(2, "m/s", constraints=[lambda a, near: a])}),
        r"'near', which is not in the graph",
    ),
    "a constraint that takes anything": (
        lambda: model(actuators={"a": Actuator(2, "m/s", constraints=[lambda *inputs: inputs[0]])}),
        r"'\*inputs' names no quantity",
    ),
    "an actuator that moves no goal": (
        lambda: model(actuators={"a": Actuator(2, "m/s"), "b": Actuator(1, "m/s")}),
        r"No goal depends on the actuator 'b'. Goals: 'near'",
    ),
    "rows that are lost": (
        lambda: model(
            MOVE,
            CORNERS,
            Deterministic("y", lambda x, corners: (x * corners).sum(-2), each=["corners"]),
            goals=[Goal("g", lambda y: y.sum(-1))],
        ),
        "'y'",
    ),
    "rows of the time step": (lambda: model(MOVE, Deterministic("y", lambda x, dt: x * dt, each=["dt"]), TRACK), "'dt'"),
    "rows named by a string": (
        lambda: model(MOVE, CORNERS, TRACK, Deterministic("y", row, each="corners"), goals=[Goal("far", far)]),
        "each='corners'",
    ),
}


@pytest.mark.parametrize(("make", "culprit"), BAD.values(), ids=BAD.keys())
def test_a_model_that_cannot_work_is_refused(make: Callable[[], Any], culprit: str) -> None:
    with pytest.raises(GraphError, match=culprit):
        make()


def test_the_same_parts_make_a_model_that_works() -> None:
    assert [str(path) for path in model().paths()] == ["near → p → x → a"]


# --- order and cycles


@given(graphs(), st.randoms(use_true_random=False))
def test_estimators_may_be_listed_in_any_order(blueprint: Blueprint, random: Any) -> None:
    parts = [type(part)(**{**vars(part), "feedback": ()}) for part in blueprint.parts]
    straight = Blueprint(blueprint.actuators, tuple(parts), blueprint.goals)
    random.shuffle(parts)
    shuffled = Blueprint(blueprint.actuators, tuple(parts), blueprint.goals)
    try:
        first, second = straight.build(), shuffled.build()
    except GraphError as error:
        assume("depends on" not in str(error))
        raise
    assert {str(path) for path in first.paths()} == {str(path) for path in second.paths()}
    before, after = in_motion(first), in_motion(second)
    assert before.keys() == after.keys()
    for name in before:
        torch.testing.assert_close(before[name], after[name])


def rotate(p: Tensor, q: Tensor, x: Tensor) -> Tensor:
    return p + torch.tanh(p * q) * x


def follow(q: Tensor, p: Tensor, x: Tensor) -> Tensor:
    return q + torch.tanh(p * q) * x


def cyclic() -> WorldModel:
    def product(p: Tensor, q: Tensor) -> Tensor:
        return (p * q).sum(-1)

    first = EKF("p", "P", predict=rotate, noise=0.1, initial=((0.1, 0.2), 1.0))
    second = EKF("q", "Q", predict=follow, noise=0.1, initial=((0.3, 0.5), 1.0))
    return model(first, second, Deterministic("x", move), goals=[Goal("product", product)])


def test_in_a_cycle_one_reads_the_value_of_the_last_step() -> None:
    graph = cyclic()
    values = {**in_motion(graph), "a": torch.tensor([0.3, -0.2], dtype=torch.float64)}
    after, _ = graph.step(values)
    x = 0.1 * values["a"]
    first, second = (name for node in graph.nodes for name in node.outputs if name in "pq")
    relations = {"p": rotate, "q": follow}
    torch.testing.assert_close(after[first], relations[first](values[first], values[second], x))
    torch.testing.assert_close(after[second], relations[second](values[second], after[first], x))
    sources = {edge.source for edge in graph.edges[first]}
    assert sources == {"x"}
    assert {edge.source for edge in graph.edges[second]} == {"x", first}


def test_a_filter_that_nothing_moves_can_stand_in_a_graph() -> None:
    """A static landmark that is only measured, with a nonlinear prediction."""

    def apart(p: Tensor, home: Tensor) -> Tensor:
        return ((p - home) ** 2).sum(-1)

    def stay(home: Tensor) -> Tensor:
        return home * 1.0

    home = EKF("home", "P_home", predict=stay, noise=0.0, initial=((1.0, 1.0), 1.0), correct=[
        Measurement(lambda home, z: home - z, 0.1, size=2)
    ])  # fmt: skip
    graph = model(Deterministic("x", move), tracked(), home, goals=[Goal("apart", apart)])
    assert [str(path) for path in graph.paths()] == ["apart → p → x → a"]
    after, _ = graph.step(in_motion(graph))
    assert after["P_home"].diagonal().max() < 1.0


# --- steps


@given(graphs(), st.sampled_from([(), (3,)]))
def test_estimation_alone_gives_the_same_values(blueprint: Blueprint, batch: tuple[int, ...]) -> None:
    try:
        graph = blueprint.build()
    except GraphError as error:
        assume("depends on" not in str(error))
        raise
    values = in_motion(graph, batch) | actions(graph, batch, 9) | readings(batch, 9)
    after, tapes = graph.step(values)
    alone, none = graph.step(values, differentiable=False)
    assert not none
    assert set(tapes) == set(graph.edges)
    for name in after:
        assert not after[name].requires_grad
        torch.testing.assert_close(after[name], alone[name], rtol=1e-12, atol=1e-12)
        if name not in {*graph.sensors, *graph.actuators}:
            assert after[name].shape == (*batch, *graph.quantities[name].shape)


@given(graphs())
def test_the_uncut_model_stands_at_the_values_of_the_step(blueprint: Blueprint) -> None:
    try:
        graph = blueprint.build()
    except GraphError as error:
        assume("depends on" not in str(error))
        raise
    values = in_motion(graph)
    costs = graph.uncut(values, {name: values[name].clone().requires_grad_() for name in graph.actuators})
    for name, goal in graph.goals.items():
        torch.testing.assert_close(costs[name], goal({**values, "dt": graph.dt}))


def test_a_model_starts_at_rest_at_its_priors() -> None:
    graph = model(
        Deterministic("x", lambda a: a + 1.0), tracked(initial=lambda z: (2.0 * z, torch.diag_embed(z**2)), size=2)
    )
    z = torch.tensor([[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]], dtype=torch.float64)
    values = graph.initial({"z": z}, (3,))
    assert not values["a"].any()
    assert torch.equal(values["p"], 2.0 * z)
    assert torch.equal(values["P"], torch.diag_embed(z**2))
    assert (values["x"] == 1.0).all()
    constant = model().initial({"z": z}, (3,))
    assert torch.equal(constant["p"], torch.tensor([1.0, 2.0], dtype=torch.float64).expand(3, 2))
    assert torch.equal(constant["P"], torch.eye(2, dtype=torch.float64).expand(3, 2, 2))


def test_constants_follow_the_precision() -> None:
    for dtype in (torch.float32, torch.float64):
        values = in_motion(model(dtype=torch.float64)) if dtype is torch.float64 else None
        graph = model(dtype=dtype)
        start = graph.initial({"z": torch.zeros(2, dtype=dtype)}, ())
        after, _ = graph.step(start)
        assert all(value.dtype == dtype for value in after.values())
        assert values is None or values["p"].dtype == dtype


def test_dt_may_be_read_by_every_function() -> None:
    for dt in (0.1, 0.5):
        graph = model(dt=dt)
        values = {**in_motion(graph), "a": torch.ones(2, dtype=torch.float64)}
        assert graph.step(values)[0]["x"].tolist() == [dt, dt]


def test_linear_and_extended_filters_agree_in_a_graph() -> None:
    linear = KalmanFilter("p", "P", predict=Affine(p=1.0, x=-1.0), noise=0.1, initial=((1.0, 2.0), 1.0), correct=[
        Measurement(Affine(p=1.0, z=-1.0), 0.1, size=2)
    ])  # fmt: skip
    uncertainty = Goal("both", lambda p, P: (p**2).sum(-1) + P.diagonal(dim1=-2, dim2=-1).sum(-1))
    graphs = [model(Deterministic("x", move), node, goals=[uncertainty]) for node in (linear, tracked())]
    values = [in_motion(graph) for graph in graphs]
    slopes = [totals(g, v, {"a": v["a"]})["a"] for g, v in zip(graphs, values, strict=True)]
    for name in values[0]:
        torch.testing.assert_close(values[0][name], values[1][name])
    torch.testing.assert_close(*slopes)


def test_a_filter_that_only_predicts_remembers_no_gradient() -> None:
    """Its prediction is linearised under autograd; neither that nor its own last value may stay in the memory."""
    for size in (1, 2):

        def drift(p: Tensor, x: Tensor, size: int = size) -> Tensor:
            return torch.sin(p) + x[..., :size]

        alone = EKF("p", "P", predict=drift, noise=0.1, initial=((0.3, 0.2)[:size], 1.0))
        policy = Policy(model(Deterministic("x", move), alone), Sum(), ActionLaw(1.0))
        memory = None
        for _ in range(3):
            _, memory = policy.predict({"z": normal(2)}, memory)
            assert not [name for name, value in memory.items() if value.requires_grad]


# --- rows


def cornered(**options: Any) -> WorldModel:
    return model(MOVE, CORNERS, Deterministic("y", row, each=["corners"]), goals=[Goal("far", far)], **options)


def test_a_function_of_each_row_is_written_for_one() -> None:
    graph = cornered()
    assert [str(path) for path in graph.paths()] == [f"far → y[{i}] → x → a" for i in range(3)]
    assert graph.quantities["y"].shape == (3, 2)
    for batch in ((), (4,), (3,), (2, 3)):
        values = graph.initial({"z": normal(*batch, 2)}, batch) | {"a": normal(*batch, 2, seed=1)}
        after, _ = graph.step(values)
        expected = [0.1 * values["a"] * i * values["z"] for i in (1, 2, 3)]
        torch.testing.assert_close(after["y"], torch.stack(expected, dim=-2))


def test_functions_of_rows_may_read_rows_and_constants() -> None:
    """A second rowed function of the same rows, read as a whole by a third, with ``dt`` among the inputs."""
    graph = model(
        MOVE,
        CORNERS,
        Deterministic("y", row, each=["corners"]),
        Deterministic("w", lambda y, a, corners, dt: y + dt * a - corners, each=["corners", "y"]),
        Deterministic("s", lambda w: w.sum(-2)),
        goals=[Goal("near", lambda s: (s**2).sum(-1))],
    )
    assert [str(path) for path in graph.paths()] == [
        *(f"near → s → w → y[{i}] → x → a" for i in range(3)),
        *(f"near → s → w[{i}] → a" for i in range(3)),
    ]
    assert len(graph.paths()) == 6
    assert [str(path) for path in graph.paths(max_length=3)] == [f"near → s → w[{i}] → a" for i in range(3)]


def test_a_rowed_quantity_can_be_displaced() -> None:
    graph = cornered()
    values, _ = graph.step(graph.initial({"z": normal(5, 2)}, (5,)) | {"a": normal(5, 2, seed=1)})
    shift = normal(5, 3, 2, seed=2)
    torch.testing.assert_close(graph.displaced_cost("far", "y", shift, values), far(values["y"] + shift))
    moved = (values["x"] + shift[:, 0]).unsqueeze(-2) * values["corners"]
    torch.testing.assert_close(graph.displaced_cost("far", "x", shift[:, 0], values), far(moved))


# --- displaced costs


def test_a_displaced_motion_moves_what_it_moves() -> None:
    """Had the robot not moved by s, the target would be at p + s; covariances stay as they are."""

    def cost(p: Tensor, P: Tensor) -> Tensor:
        return p.norm(dim=-1) + P.diagonal(dim1=-2, dim2=-1).sum(-1)

    graph = model(Deterministic("x", move, is_motion=True), tracked(), goals=[Goal("cost", cost)])
    values = in_motion(graph, (3,))
    shift = torch.tensor([0.3, -0.1], dtype=torch.float64).expand(3, 2)
    displaced = graph.displaced_cost("cost", "x", -shift, values)
    torch.testing.assert_close(displaced, cost(values["p"] + shift, values["P"]))
    torch.testing.assert_close(graph.displaced_cost("cost", "p", shift, values), cost(values["p"] + shift, values["P"]))


# --- pictures and paths


def test_mermaid_shows_every_node_and_its_readers() -> None:
    drawn = cyclic().to_mermaid().splitlines()
    assert drawn[0] == "flowchart LR"
    body = "\n".join(drawn[1:])
    for name in ("z", "a", "x", "p", "P", "q", "Q", "product"):
        assert name in body
    arrows = {line.strip() for line in drawn if "-->" in line}
    assert arrows == {
        f"{source} --> {reader}"
        for source, reader in (
            ("a", "x"),
            ("x", "p"),
            ("q", "p"),
            ("p", "q"),
            ("x", "q"),
            ("p", "product"),
            ("q", "product"),
        )
    }


@given(blueprints())
def test_mermaid_lists_random_graphs_completely(blueprint: Blueprint) -> None:
    try:
        graph = blueprint.build()
    except GraphError as error:
        assume("depends on" not in str(error))
        raise
    drawn = graph.to_mermaid()
    for name in (*graph.quantities, *graph.goals):
        assert name in drawn
    for path in graph.paths():
        assert path.goal in drawn


def test_paths_can_be_bounded() -> None:
    graph = cyclic()
    assert {len(path.quantities) for path in graph.paths()} == {2, 3}
    assert all(len(path.quantities) == 2 for path in graph.paths(max_length=3))
    assert len(graph.paths(max_length=2)) == 0
