"""Quantities with rows: each row pulls on its own."""

import pytest
import torch
from _asserts import along, totals
from _inputs import Row, anchors, distances, moved, plain_sum, rowed_model, rows_of, unlimited
from torch import Tensor

from aicon_torch import Deterministic, Goal, NullspaceProjection, SteepestPath, Sum


@pytest.mark.parametrize("count", [1, 2, 5])
@pytest.mark.parametrize("batch", [(), (4,), (2, 3)], ids=str)
def test_each_row_pulls_as_if_the_other_rows_were_constants(
    count: int, batch: tuple[int, ...]
) -> None:
    goals = [Goal("g", distances("y"))]
    model = rowed_model(*rows_of(y=count), goals=goals)
    memory, start = moved(unlimited(model, SteepestPath()), batch)
    local = model.record({**{name: memory[name] for name in model.quantities}, "a": start["a"]})
    paths = list(model.paths())

    assert [str(path) for path in paths] == [f"g → y[{row}] → x → a" for row in range(count)]

    for row, path in enumerate(paths):

        def only(x: Tensor, r: Tensor, row: int = row) -> Tensor:
            value = Row(0)(x.unsqueeze(-2), r)
            return torch.where(torch.arange(count).unsqueeze(-1) == row, value, value.detach())

        alone = rowed_model(
            Deterministic("r", anchors(count)), Deterministic("y", only), goals=goals
        )
        expected, _ = moved(unlimited(alone, Sum()), batch)

        torch.testing.assert_close(
            along(path, model, local), -expected["a"], rtol=1e-12, atol=1e-12
        )


@pytest.mark.parametrize("batch", [(), (3,)], ids=str)
def test_the_steepest_path_may_be_a_row(batch: tuple[int, ...]) -> None:
    model = rowed_model(*rows_of(y=3, w=2), goals=[Goal("g", distances("y", "w", beside="x"))])
    policy = unlimited(model, SteepestPath())
    memory, start = moved(policy, batch)
    local = model.record({**{name: memory[name] for name in model.quantities}, "a": start["a"]})
    by_label = {str(path): along(path, model, local) for path in model.paths()}

    assert {f"{arrival} → a" for arrival in policy.backward_pass.arrivals["a"]} == by_label.keys()

    for index, arrival in enumerate(
        policy.backward_pass.arrivals["a"]
    ):  # what is remembered stands under its label
        torch.testing.assert_close(memory["a/gradients"][..., index, :], by_label[f"{arrival} → a"])
    stack = torch.stack(list(by_label.values()), dim=-2)
    longest = stack.norm(dim=-1).argmax(-1)[..., None, None]

    torch.testing.assert_close(-memory["a"], stack.take_along_dim(longest, -2).squeeze(-2))


def test_a_rowed_quantity_is_one_quantity_where_its_gradients_meet() -> None:
    """Two goals meet at y.

    One candidate each, over all components; what leaves comes apart into rows further on.
    """
    model = rowed_model(*rows_of(y=3), goals=[Goal("g", distances("y")), Goal("h", distances("y"))])
    policy = unlimited(model, plain_sum(by_row=False))
    memory, start = moved(policy, (2,))

    assert memory["y/gradients"].shape == (2, 2, 6)
    assert [str(arrival) for arrival in policy.backward_pass.arrivals["x"]] == [
        f"g+h → y[{row}]" for row in range(3)
    ]

    total = totals(model, {name: memory[name] for name in model.quantities}, {"a": start["a"]})
    torch.testing.assert_close(memory["a"], -total["a"])


def test_rows_that_meet_elsewhere_are_explained_by_row() -> None:
    model = rowed_model(*rows_of(y=3), goals=[Goal("g", distances("y"))])
    policy = unlimited(model, NullspaceProjection(temperature=None))
    memory, _ = moved(policy)
    report = policy.explain(memory).meetings["x"]

    assert [candidate.trace for candidate in report.candidates] == [
        f"g → y[{row}] → x" for row in range(3)
    ]

    lengths = memory["x/gradients"].norm(dim=-1)
    assert [candidate.strength for candidate in report.candidates] == pytest.approx(
        lengths.tolist()
    )
    assert report.candidates[int(lengths.argmax())].rank == 0
