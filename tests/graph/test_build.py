"""A graph is put in order: estimators in any order, cycles, filters that nothing moves."""

from typing import Any

import torch
from _inputs import (
    MOVE,
    TRACK,
    Blueprint,
    built,
    cyclic,
    follow,
    graphs,
    in_motion,
    rotate,
    tracking_model,
)
from hypothesis import given
from hypothesis import strategies as st
from torch import Tensor

from aicon_torch import EKF, Goal, Measurement


@given(graphs(), st.randoms(use_true_random=False))
def test_estimators_may_be_listed_in_any_order(blueprint: Blueprint, random: Any) -> None:
    parts = [type(part)(**{**vars(part), "feedback": ()}) for part in blueprint.parts]
    straight = Blueprint(blueprint.actuators, tuple(parts), blueprint.goals)
    random.shuffle(parts)
    shuffled = Blueprint(blueprint.actuators, tuple(parts), blueprint.goals)

    first, second = built(straight), built(shuffled)
    assert {str(path) for path in first.paths()} == {str(path) for path in second.paths()}

    before, after = in_motion(first), in_motion(second)
    assert before.keys() == after.keys()

    for name in before:
        torch.testing.assert_close(before[name], after[name])


def test_in_a_cycle_one_reads_the_value_of_the_last_step() -> None:
    graph = cyclic()
    values = {**in_motion(graph), "a": torch.tensor([0.3, -0.2], dtype=torch.float64)}
    after = graph.update(values)

    x = 0.1 * values["a"]
    first, second = (name for node in graph.estimators for name in node.outputs if name in "pq")
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

    def seen(home: Tensor, z: Tensor) -> Tensor:
        return home - z

    home = EKF(
        "home",
        "P_home",
        predict=stay,
        noise=0.0,
        initial=((1.0, 1.0), 1.0),
        correct=[Measurement(seen, 0.1, size=2)],
    )
    graph = tracking_model(MOVE, TRACK, home, goals=[Goal("apart", apart)])
    assert [str(path) for path in graph.paths()] == ["apart → p → x → a"]

    after = graph.update(in_motion(graph))
    assert after["P_home"].diagonal().max() < 1.0
