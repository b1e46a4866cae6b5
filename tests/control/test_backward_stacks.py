"""Where gradients meet, and what the backward pass knows about each of them."""

from dataclasses import dataclass, field

import pytest
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
from aicon_torch.resolution import GradientStack, Memory

READING = {"z": torch.zeros(1, dtype=torch.float64)}


def fork() -> WorldModel:
    """Two goals meet at y and a third joins them at x."""

    def move(a: Tensor) -> Tensor:
        return a

    return WorldModel(
        sensors={"z": Sensor(1, "m")},
        actuators={"a": Actuator(2, "m")},
        estimators=[Deterministic("x", move), Deterministic("y", lambda x: 2.0 * x)],
        goals=[
            Goal("up", lambda y: y[..., 1]),
            Goal("down", lambda y: 0.3 * y[..., 0] - 0.2 * y[..., 1]),
            Goal("side", lambda x: 0.1 * x[..., 0]),
        ],
        dtype=torch.float64,
    )


def test_gradients_are_resolved_at_every_quantity_where_they_meet() -> None:
    rule = NullspaceProjection(temperature=None, exploration=None)
    _, memory = unlimited(fork(), rule).predict(READING)

    # At y the sum of what is left, (0.3, 1.0), goes on, times two.
    expected = {"y": [[0.0, 1.0], [0.3, -0.2]], "x": [[0.1, 0.0], [0.6, 2.0]]}
    for name, stack in expected.items():
        found = torch.tensor(sorted(memory[f"{name}/gradients"].tolist()), dtype=torch.float64)
        torch.testing.assert_close(found, torch.tensor(stack, dtype=torch.float64))

    # A single gradient arrives at the actuator.
    assert "a/gradients" not in memory
    assert memory["a/gradient"].tolist() == (-memory["a"]).tolist()


@dataclass(frozen=True)
class Listening(Sum):
    """The sum, which notes for each stack whether it is the last one."""

    heard: dict[frozenset[str], bool] = field(default_factory=dict)

    def __call__(self, stack: GradientStack, memory: Memory) -> tuple[Tensor, Memory]:
        self.heard[stack.all_goals] = stack.is_last
        return super().__call__(stack, memory)


def test_it_knows_where_gradients_meet_for_the_last_time() -> None:
    rule = Listening()
    unlimited(fork(), rule).predict(READING)
    assert rule.heard == {frozenset(["up", "down"]): False, frozenset(["up", "down", "side"]): True}


def test_partial_paths_tell_where_each_gradient_comes_from() -> None:
    paths = BackwardPass(fork(), NullspaceProjection()).paths
    assert {str(path) for path in paths["y"]} == {"up", "down"}
    assert {str(path) for path in paths["x"]} == {"up+down → y", "side"}
    assert {path.goals for path in paths["x"]} == {frozenset(["up", "down"]), frozenset(["side"])}

    every_path = BackwardPass(fork(), SteepestPath()).paths
    expected = {str(path) for path in fork().paths()}
    assert {f"{path} → a" for path in every_path["a"]} == expected


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
    _, memory = unlimited(model, Sum()).predict(READING)
    assert memory["a"].tolist() == [-3.0, 1.0]


@pytest.mark.parametrize(
    ("off", "expected"),
    [({"up": False}, [-0.7, 0.4]), ({"up": False, "down": 0.0}, [-0.1, 0.0])],
    ids=str,
)
def test_switched_off_goals_pull_nothing(off: dict[str, float], expected: list[float]) -> None:
    policy = unlimited(fork(), Sum())
    _, memory = policy.predict(READING)

    action, _ = policy.predict(READING, policy.switch(memory, **off))
    torch.testing.assert_close(action, torch.tensor(expected, dtype=torch.float64))
