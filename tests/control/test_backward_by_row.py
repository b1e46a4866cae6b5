"""Quantities with rows: what comes from the same row is summed."""

import pytest
import torch
from _asserts import totals
from _inputs import distances, moved, plain_sum, rowed_model, rows_of, unlimited
from torch import Tensor

from aicon_torch import Deterministic, Goal, Policy
from aicon_torch.control import BackwardPass


def arrived(policy: Policy, memory: dict[str, Tensor]) -> dict[frozenset[str], Tensor]:
    """The gradients at x by the last quantities that they came through."""
    labels = [
        frozenset(arrival.trace[-1].split("+")) for arrival in policy.backward_pass.arrivals["x"]
    ]
    gradients = memory["x/gradients"].unbind(-2)
    assert len(set(labels)) == len(labels)
    return dict(zip(labels, gradients, strict=True))


FAMILIES: dict[str, tuple[dict[str, int], list[str]]] = {
    "one": ({"y": 3}, ["y[0]", "y[1]", "y[2]"]),
    "two of a kind": ({"y": 2, "w": 2}, ["y[0] w[0]", "y[1] w[1]"]),
    "two kinds": ({"y": 2, "w": 3}, ["y[0]", "y[1]", "w[0]", "w[1]", "w[2]"]),
    "three of a kind and another": (
        {"y": 2, "w": 2, "v": 1, "u": 2},
        ["y[0] w[0] u[0]", "y[1] w[1] u[1]", "v[0]"],
    ),
    "a single row of each": ({"y": 1, "w": 1}, ["y[0] w[0]"]),
}
"""Numbers of rows by quantity, and which of them are summed."""


@pytest.mark.parametrize(("families", "together"), FAMILIES.values(), ids=FAMILIES.keys())
@pytest.mark.parametrize("batch", [(), (2, 3)], ids=str)
def test_by_row_sums_what_comes_from_the_same_row(
    families: dict[str, int], together: list[str], batch: tuple[int, ...]
) -> None:
    """And what comes from elsewhere stays a candidate of its own.

    Another goal's gradient, and another function's.
    """
    plain = Deterministic("n", lambda x: torch.tanh(2.0 * x))
    goals = [Goal("g", distances(*families, beside="n")), Goal("direct", distances(beside="x"))]
    model = rowed_model(plain, *rows_of(**families), goals=goals)
    apart, joined = (unlimited(model, plain_sum(by_row)) for by_row in (False, True))
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
    model = rowed_model(
        *rows_of(y=3, w=3, v=2, u=2), goals=[Goal("g", distances("y", "w", "v", "u"))]
    )
    policy = unlimited(model, plain_sum())
    memory, start = moved(policy)

    assert {frozenset("yw"), frozenset("vu")} == {
        frozenset(label[0] for label in labels) for labels in arrived(policy, memory)
    }

    total = totals(model, {name: memory[name] for name in model.quantities}, {"a": start["a"]})
    torch.testing.assert_close(memory["a"], -total["a"])


def test_a_row_that_two_goals_share_is_of_both() -> None:
    model = rowed_model(
        *rows_of(y=2, w=2), goals=[Goal("g", distances("y")), Goal("h", distances("w"))]
    )
    policy = unlimited(model, plain_sum())
    arrivals = policy.backward_pass.arrivals["x"]

    assert [arrival.goals for arrival in arrivals] == 2 * [frozenset("gh")]
    assert [
        {part in str(arrival) for part in ("g → y[0]", "h → w[0]")} for arrival in arrivals
    ] == [{True}, {False}]

    memory, start = moved(policy)
    total = totals(model, {name: memory[name] for name in model.quantities}, {"a": start["a"]})

    torch.testing.assert_close(memory["a"], -total["a"])


def test_by_row_loses_nothing_where_one_candidate_is_left() -> None:
    model = rowed_model(*rows_of(y=1, w=1), goals=[Goal("g", distances("y", "w"))])
    memory, start = moved(unlimited(model, plain_sum()))
    total = totals(model, {name: memory[name] for name in model.quantities}, {"a": start["a"]})
    torch.testing.assert_close(memory["a"], -total["a"])


def test_by_row_keeps_rows_of_unrelated_things_apart() -> None:
    """Two landmarks and two obstacles.

    The first landmark has nothing to do with the first obstacle.
    """
    model = rowed_model(
        *rows_of(y=2),
        *rows_of("o", w=2),
        goals=[Goal("g", distances("y")), Goal("h", distances("w"))],
    )

    arrivals = BackwardPass(model, plain_sum()).arrivals["x"]
    assert {arrival.goals for arrival in arrivals} == {frozenset("g"), frozenset("h")}
