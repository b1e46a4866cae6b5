"""Quantities with rows: each row pulls on its own."""

import pytest
import torch
from _asserts import along, arrived, totals
from _inputs import (
    Row,
    anchors,
    distances,
    moved,
    plain_sum,
    quantities,
    rowed_model,
    rows_of,
    unlimited,
)
from torch import Tensor

from aicon_torch import Deterministic, Goal, NullspaceProjection, SteepestPath, Sum


@pytest.mark.parametrize("count", [1, 2, 5])
@pytest.mark.parametrize("batch", [(), (4,), (2, 3)], ids=str)
def test_each_row_pulls_as_if_the_other_rows_were_constants(
    count: int, batch: tuple[int, ...]
) -> None:
    goals = [Goal("g", distances("y"))]
    model = rowed_model(*rows_of(y=count), goals=goals)
    paths = list(model.paths())
    assert [str(path) for path in paths] == [f"g → y[{row}] → x → a" for row in range(count)]

    memory, start = moved(unlimited(model, SteepestPath()), batch)
    local = model.record(quantities(model, memory, start["a"]))

    for row, path in enumerate(paths):

        def only_this_row(x: Tensor, r: Tensor, row: int = row) -> Tensor:
            value = Row(0)(x.unsqueeze(-2), r)
            is_row = torch.arange(count).unsqueeze(-1) == row
            return torch.where(is_row, value, value.detach())

        placed, rows = Deterministic("r", anchors(count)), Deterministic("y", only_this_row)
        expected, _ = moved(unlimited(rowed_model(placed, rows, goals=goals), Sum()), batch)

        gradient = along(path, model, local)
        torch.testing.assert_close(gradient, -expected["a"], rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("batch", [(), (3,)], ids=str)
def test_the_steepest_path_may_be_a_row(batch: tuple[int, ...]) -> None:
    model = rowed_model(*rows_of(y=3, w=2), goals=[Goal("g", distances("y", "w", beside="x"))])
    policy = unlimited(model, SteepestPath())
    memory, start = moved(policy, batch)

    local = model.record(quantities(model, memory, start["a"]))
    expected = {str(path): along(path, model, local) for path in model.paths()}

    # What is remembered stands under its label.
    found = arrived(policy, memory, "a")
    assert found.keys() == expected.keys()
    for label, gradient in expected.items():
        torch.testing.assert_close(found[label], gradient)

    stack = torch.stack(list(expected.values()), dim=-2)
    longest = stack.norm(dim=-1).argmax(-1)[..., None, None]
    torch.testing.assert_close(-memory["a"], stack.take_along_dim(longest, -2).squeeze(-2))


def test_a_rowed_quantity_is_one_quantity_where_its_gradients_meet() -> None:
    """Two goals meet at y: one candidate each, over all components.

    What leaves comes apart into rows further on.
    """
    goals = [Goal("g", distances("y")), Goal("h", distances("y"))]
    model = rowed_model(*rows_of(y=3), goals=goals)
    policy = unlimited(model, plain_sum(by_row=False))
    memory, start = moved(policy, (2,))

    assert memory["y/gradients"].shape == (2, 2, 6)
    expected = [f"g+h → y[{row}] → x" for row in range(3)]
    assert list(arrived(policy, memory, "x")) == expected

    total = totals(model, quantities(model, memory, memory["a"]), {"a": start["a"]})
    torch.testing.assert_close(memory["a"], -total["a"])


def test_rows_that_meet_elsewhere_are_explained_by_row() -> None:
    model = rowed_model(*rows_of(y=3), goals=[Goal("g", distances("y"))])
    policy = unlimited(model, NullspaceProjection(temperature=None))
    memory, _ = moved(policy)

    candidates = policy.explain(memory).quantities["x"].candidates
    assert [candidate.path for candidate in candidates] == [f"g → y[{row}] → x" for row in range(3)]

    lengths = memory["x/gradients"].norm(dim=-1)
    magnitudes = [candidate.magnitude for candidate in candidates]
    assert magnitudes == pytest.approx(lengths.tolist())
    assert candidates[int(lengths.argmax())].rank == 0
