"""What cannot work is refused at construction, each with its culprit: shapes, batches and rows."""

from collections.abc import Callable
from typing import Any

import pytest
import torch
from _inputs import (
    CORNERS,
    MOVE,
    TRACK,
    approach,
    far,
    match,
    of_corner,
    tracked_point,
    tracking_model,
)
from torch import Tensor

from aicon_torch import Affine, Deterministic, Goal, GraphError, Interconnection, Measurement


def rows_first(a: Tensor) -> Tensor:
    return torch.stack((-a[1], a[0]))


def unpacked(a: Tensor) -> Tensor:
    right, up = a
    return torch.stack((-up, right))


def scalar(a: Tensor) -> Tensor:
    return a.norm(dim=-1)


def summed_over_everything(a: Tensor) -> Tensor:
    return a.sum()


def in_numpy(a: Tensor) -> Any:
    return a.detach().numpy()


def a_number(a: Tensor) -> Any:
    return float(a.sum())


MISSHAPEN: dict[str, tuple[Callable[[], Any], str]] = {
    "shapes that do not match": (
        lambda: tracking_model(Deterministic("x", Affine(a=torch.ones(3, 5))), TRACK),
        r"'x' cannot be evaluated",
    ),
    "an array of numpy": (
        lambda: tracking_model(Deterministic("x", in_numpy), TRACK),
        r"'x' is a ndarray; expected a tensor",
    ),
    "a cost that is a number": (
        lambda: tracking_model(MOVE, TRACK, goals=[Goal("far", a_number)]),
        r"'far' is a float; expected a tensor",
    ),
    "a prediction of another size": (
        lambda: tracking_model(
            MOVE, tracked_point(predict=lambda p, x: torch.cat((p, x), -1), correct=[])
        ),
        r"'p'|'P'",
    ),
    "rows before the batch": (
        lambda: tracking_model(Deterministic("x", rows_first), TRACK),
        r"'x'",
    ),
    "components unpacked from the batch": (
        lambda: tracking_model(Deterministic("x", unpacked), TRACK),
        r"'x'",
    ),
    "a quantity without components": (
        lambda: tracking_model(Deterministic("x", scalar), goals=[Goal("g", lambda x: x)]),
        r"'x'.*\(n,\)",
    ),
    "a function that sums over the batch": (
        lambda: tracking_model(
            Deterministic("x", summed_over_everything), goals=[Goal("g", lambda x: x)]
        ),
        r"'x' has shape \(\)",
    ),
    "a cost with components": (
        lambda: tracking_model(goals=[Goal("near", lambda p: p)]),
        r"Goal 'near'",
    ),
    "a cost summed over the batch": (
        lambda: tracking_model(goals=[Goal("near", lambda p: p.sum())]),
        r"Goal 'near'",
    ),
    "a cost that cannot be evaluated": (
        lambda: tracking_model(goals=[Goal("near", lambda p, z: p @ z)]),
        r"'near'",
    ),
    "a residual of another size": (
        lambda: tracking_model(MOVE, tracked_point(correct=[Measurement(match, 0.1)])),
        r"measurement 0 of 'p' gives 2 components, size=1; expected .*size=2",
    ),
    "a wrong Jacobian": (
        lambda: tracking_model(
            MOVE,
            tracked_point(
                predict=Interconnection(approach, p=lambda p: 2 * torch.eye(2, dtype=p.dtype))
            ),
        ),
        r"Jacobian of .*approach.* by 'p' is not its derivative",
    ),
}


@pytest.mark.parametrize(("make", "culprit"), MISSHAPEN.values(), ids=MISSHAPEN.keys())
def test_shapes_that_do_not_fit_are_refused(make: Callable[[], Any], culprit: str) -> None:
    with pytest.raises(GraphError, match=culprit):
        make()


# --- rows


def both(x: Tensor, corners: Tensor, four: Tensor) -> Tensor:
    return x * corners + four


def read_whole(w: Tensor, corners: Tensor) -> Tensor:
    return w * corners


FOUR = Deterministic("four", lambda z: torch.stack(4 * [z], dim=-2))


MISROWED: dict[str, tuple[Callable[[], Any], str]] = {
    "rows of what is not read": (
        lambda: tracking_model(MOVE, Deterministic("y", of_corner, each=["r"])),
        r"Deterministic 'y': each='r', but it reads 'x', 'corners'",
    ),
    "rows of different number": (
        lambda: tracking_model(
            MOVE, CORNERS, FOUR, TRACK, Deterministic("y", both, each=["corners", "four"])
        ),
        r"'y' cannot be evaluated",
    ),
    "rows of different number, one of them not announced": (
        lambda: tracking_model(
            MOVE, CORNERS, FOUR, TRACK, Deterministic("y", both, each=["corners"])
        ),
        r"'y' cannot be evaluated",
    ),
    "rows that are read as a vector": (
        lambda: tracking_model(MOVE, CORNERS, TRACK, Deterministic("y", of_corner)),
        r"'y' cannot be evaluated",
    ),
    "rows of a plain vector": (
        lambda: tracking_model(MOVE, TRACK, Deterministic("y", lambda x, z: x * z, each=["z"])),
        r"'y' reads 'z' of shape \(2,\)",
    ),
    "rows on a path that are not announced": (
        lambda: tracking_model(
            MOVE,
            CORNERS,
            TRACK,
            Deterministic("w", of_corner, each=["corners"]),
            Deterministic("y", read_whole, each=["corners"]),
        ),
        r"'y' reads 'w' of shape \(3, 2\); expected \(n,\), as each= does not name it",
    ),
    "rows beside a matrix": (
        lambda: tracking_model(
            MOVE,
            CORNERS,
            TRACK,
            Deterministic("y", lambda x, corners, P: x * corners, each=["corners"]),
        ),
        r"'y' reads 'P' of shape \(2, 2\)",
    ),
    "rows that are lost": (
        lambda: tracking_model(
            MOVE,
            CORNERS,
            Deterministic("y", lambda x, corners: (x * corners).sum(-2), each=["corners"]),
            goals=[Goal("g", lambda y: y.sum(-1))],
        ),
        "'y'",
    ),
    "rows of the time step": (
        lambda: tracking_model(MOVE, Deterministic("y", lambda x, dt: x * dt, each=["dt"]), TRACK),
        "'dt'",
    ),
    "rows named by a string": (
        lambda: tracking_model(
            MOVE,
            CORNERS,
            TRACK,
            Deterministic("y", of_corner, each="corners"),
            goals=[Goal("far", far)],
        ),
        "each='corners'",
    ),
}


@pytest.mark.parametrize(("make", "culprit"), MISROWED.values(), ids=MISROWED.keys())
def test_rows_that_do_not_fit_are_refused(make: Callable[[], Any], culprit: str) -> None:
    with pytest.raises(GraphError, match=culprit):
        make()
