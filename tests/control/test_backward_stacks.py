"""Where gradients meet, and what the backward pass knows about each of them."""

import torch
from _inputs import unlimited
from torch import Tensor

from aicon_torch import (
    Actuator,
    Deterministic,
    Goal,
    NullspaceProjection,
    Sensor,
    SteepestPath,
    Sum,
    WorldModel,
    by_sign,
)
from aicon_torch.control import BackwardPass


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
    expected = {
        "y": [[0.0, 1.0], [0.3, -0.2]],
        "x": [[0.6, 2.0], [0.1, 0.0]],
    }  # at y 0.3, 1.0 leaves, times two

    for name, stack in expected.items():
        arrived = torch.tensor(sorted(memory[f"{name}/gradients"].tolist()), dtype=torch.float64)
        torch.testing.assert_close(arrived, torch.tensor(sorted(stack), dtype=torch.float64))

    assert "a/gradients" not in memory
    assert memory["a/gradient"].tolist() == (-memory["a"]).tolist()


def test_it_knows_where_gradients_meet_for_the_last_time() -> None:
    final = BackwardPass(fork(), NullspaceProjection()).final
    assert (final["y"], final["x"]) == (False, True)


def test_arrivals_tell_where_each_gradient_comes_from() -> None:
    backward = BackwardPass(fork(), NullspaceProjection())
    assert {str(arrival) for arrival in backward.arrivals["y"]} == {"up", "down"}
    assert {str(arrival) for arrival in backward.arrivals["x"]} == {"up+down → y", "side"}
    assert {arrival.goals for arrival in backward.arrivals["x"]} == {
        frozenset(["up", "down"]),
        frozenset(["side"]),
    }

    every_path = BackwardPass(fork(), SteepestPath())
    assert {f"{arrival} → a" for arrival in every_path.arrivals["a"]} == {
        str(path) for path in fork().paths()
    }


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
