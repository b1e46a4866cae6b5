"""Functions that are written for one row."""

import torch
from _inputs import CORNERS, MOVE, far, normal, of_corner, tracking_model

from aicon_torch import Deterministic, Goal, WorldModel


def cornered() -> WorldModel:
    y = Deterministic("y", of_corner, each=["corners"])
    return tracking_model(MOVE, CORNERS, y, goals=[Goal("far", far)])


def test_a_function_of_each_row_is_written_for_one() -> None:
    graph = cornered()
    assert [str(path) for path in graph.paths()] == [f"far → y[{i}] → x → a" for i in range(3)]
    assert graph.quantities["y"].shape == (3, 2)

    for batch in ((), (4,), (3,), (2, 3)):
        values = graph.initial({"z": normal(*batch, 2)}, batch) | {"a": normal(*batch, 2, seed=1)}
        after = graph.update(values)

        expected = [0.1 * values["a"] * i * values["z"] for i in (1, 2, 3)]
        torch.testing.assert_close(after["y"], torch.stack(expected, dim=-2))


def test_functions_of_rows_may_read_rows_and_constants() -> None:
    """A second rowed function of the same rows reads ``dt``; a third reads it as a whole."""
    graph = tracking_model(
        MOVE,
        CORNERS,
        Deterministic("y", of_corner, each=["corners"]),
        Deterministic("w", lambda y, a, corners, dt: y + dt * a - corners, each=["corners", "y"]),
        Deterministic("s", lambda w: w.sum(-2)),
        goals=[Goal("near", lambda s: (s**2).sum(-1))],
    )

    by_way_of_y = [f"near → s → w → y[{i}] → x → a" for i in range(3)]
    direct = [f"near → s → w[{i}] → a" for i in range(3)]
    assert [str(path) for path in graph.paths()] == by_way_of_y + direct
    assert len(graph.paths()) == 6


def test_a_rowed_quantity_can_be_displaced() -> None:
    graph = cornered()
    start = graph.initial({"z": normal(5, 2)}, (5,)) | {"a": normal(5, 2, seed=1)}
    values = graph.update(start)

    shift = normal(5, 3, 2, seed=2)
    cost = graph.displaced_cost("far", "y", shift, values)
    torch.testing.assert_close(cost, far(values["y"] + shift))

    shift = shift[:, 0]
    cost = graph.displaced_cost("far", "x", shift, values)
    moved = (values["x"] + shift).unsqueeze(-2) * values["corners"]
    torch.testing.assert_close(cost, far(moved))
