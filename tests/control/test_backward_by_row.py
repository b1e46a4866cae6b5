"""Quantities with rows: what comes from the same row is summed."""

import pytest
import torch
from _asserts import arrived, totals
from _inputs import distances, moved, plain_sum, quantities, rowed_model, rows_of, unlimited
from torch import Tensor

from aicon_torch import Deterministic, Goal, Policy
from aicon_torch.control import BackwardPass

FAMILIES: dict[str, tuple[dict[str, int], list[str]]] = {
    "one": ({"y": 3}, ["y[0]", "y[1]", "y[2]"]),
    "two of a kind": ({"y": 2, "w": 2}, ["y[0]+w[0]", "y[1]+w[1]"]),
    "two kinds": ({"y": 2, "w": 3}, ["y[0]", "y[1]", "w[0]", "w[1]", "w[2]"]),
    "three of a kind and another": (
        {"y": 2, "w": 2, "v": 1, "u": 2},
        ["y[0]+w[0]+u[0]", "y[1]+w[1]+u[1]", "v[0]"],
    ),
    "a single row of each": ({"y": 1, "w": 1}, ["y[0]+w[0]"]),
}
"""Numbers of rows by quantity, and which of them are summed."""


def arrived_from(policy: Policy, memory: dict[str, Tensor]) -> dict[frozenset[str], Tensor]:
    """The gradients at x by the last quantities that they came through."""
    found: dict[frozenset[str], Tensor] = {}

    for label, gradient in arrived(policy, memory, "x").items():
        last = frozenset(label.split(" → ")[-2].split("+"))
        assert last not in found
        found[last] = gradient

    return found


def assert_descends_the_total(
    policy: Policy, memory: dict[str, Tensor], start: dict[str, Tensor], tolerance: float = 1e-7
) -> None:
    """Added up, it is the gradient of the model as one function."""
    values = quantities(policy.model, memory, memory["a"])
    total = totals(policy.model, values, {"a": start["a"]})
    torch.testing.assert_close(memory["a"], -total["a"], rtol=tolerance, atol=tolerance)


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

    # Apart: every row is a candidate.
    apart = unlimited(model, plain_sum(by_row=False))
    alone, start = moved(apart, batch)
    candidates = {
        next(iter(last)): gradient for last, gradient in arrived_from(apart, alone).items()
    }
    rows = {f"{name}[{row}]" for name, count in families.items() for row in range(count)}
    assert candidates.keys() == rows | {"n", "direct"}

    # Joined: those of the same row are summed.
    joined = unlimited(model, plain_sum(by_row=True))
    summed, _ = moved(joined, batch)
    found = arrived_from(joined, summed)
    assert found.keys() == {frozenset(names.split("+")) for names in (*together, "n", "direct")}
    for last, gradient in found.items():
        torch.testing.assert_close(gradient, sum(candidates[name] for name in last))

    assert_descends_the_total(apart, alone, start, tolerance=1e-12)
    assert_descends_the_total(joined, summed, start, tolerance=1e-12)


def test_by_row_sums_two_families_apart() -> None:
    goals = [Goal("g", distances("y", "w", "v", "u"))]
    policy = unlimited(rowed_model(*rows_of(y=3, w=3, v=2, u=2), goals=goals), plain_sum())
    memory, start = moved(policy)

    families = {frozenset(name[0] for name in last) for last in arrived_from(policy, memory)}
    assert families == {frozenset("yw"), frozenset("vu")}
    assert_descends_the_total(policy, memory, start)


def test_a_row_that_two_goals_share_is_of_both() -> None:
    goals = [Goal("g", distances("y")), Goal("h", distances("w"))]
    policy = unlimited(rowed_model(*rows_of(y=2, w=2), goals=goals), plain_sum())

    first, second = policy.backward_pass.paths["x"]
    assert first.goals == second.goals == frozenset("gh")
    for row, path in enumerate((first, second)):
        assert f"g → y[{row}]" in str(path) and f"h → w[{row}]" in str(path)
        assert f"[{1 - row}]" not in str(path)

    memory, start = moved(policy)
    assert_descends_the_total(policy, memory, start)


def test_by_row_loses_nothing_where_one_candidate_is_left() -> None:
    goals = [Goal("g", distances("y", "w"))]
    policy = unlimited(rowed_model(*rows_of(y=1, w=1), goals=goals), plain_sum())

    memory, start = moved(policy)
    assert_descends_the_total(policy, memory, start)


def test_by_row_keeps_rows_of_unrelated_things_apart() -> None:
    """Two landmarks and two obstacles.

    The first landmark has nothing to do with the first obstacle.
    """
    goals = [Goal("g", distances("y")), Goal("h", distances("w"))]
    model = rowed_model(*rows_of(y=2), *rows_of("o", w=2), goals=goals)

    paths = BackwardPass(model, plain_sum()).paths["x"]
    assert {path.goals for path in paths} == {frozenset("g"), frozenset("h")}
