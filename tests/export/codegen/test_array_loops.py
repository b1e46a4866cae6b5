"""What is done with many numbers becomes a loop: all but long sums are the same to the last bit."""

from collections.abc import Callable
from pathlib import Path

import pytest
import torch
from _asserts.loops import assert_loops_give_the_same_bits
from _inputs import normal
from _inputs.translated import SIZE, source_of, translated
from torch import Tensor

from aicon_torch.export.codegen import arrays, has_compiler

pytestmark = pytest.mark.skipif(not has_compiler(), reason="there is no C compiler")


def one_after_the_other(x: Tensor) -> Tensor:
    """Operations that go on from what the one before has computed."""
    return (x.square() + 1.0).sqrt() * x


def stacked(x: Tensor) -> Tensor:
    """Three arrays as the coordinates of points, and their lengths."""
    points = torch.stack((x.square(), x * 2.0, x.abs()), dim=-1)
    return points.clamp(min=0.5).square().sum(-1).sqrt()


def shifted(x: Tensor) -> Tensor:
    """An array that is read at other places than those where it is computed."""
    squares = x.square()
    return squares.flip(0) + squares + squares.amax()


def of_few(x: Tensor) -> Tensor:
    """Many numbers of few, none of which is in an array."""
    few = torch.stack((x[0] * x[1], x[2] + x[3], x[4] - x[5]))
    places = torch.tensor([0, 2, 1, 1, 0, 2, 2, 0, 1])
    return few[places] - few.exp()[places.flip(0)]


def of_rows_and_columns(x: Tensor) -> Tensor:
    """A grid of points and objects: what varies along one of them only, by row or column."""
    points, objects = x[:5].sin(), x.reshape(4, 3)
    radii = torch.arange(5, dtype=x.dtype)
    is_round = (objects[:, 2] > 0.0).unsqueeze(-1)
    distances = points - objects[:, :1] * objects[:, 1:2]
    return torch.where(is_round, distances - radii, points.flip(0) * objects[:, 2:]).flatten()


FUNCTIONS = {
    one_after_the_other: "for (int i",
    stacked: "for (int i",
    shifted: "for (int i",
    of_few: "for (int i",
    of_rows_and_columns: "for (int row = 0; row < 4; ++row)",
}


@pytest.mark.parametrize("function", FUNCTIONS)
@pytest.mark.parametrize(
    "dtype", [torch.float64, pytest.param(torch.float32, marks=pytest.mark.slow)], ids=str
)
def test_loops_give_the_same_bits(
    function: Callable[[Tensor], Tensor],
    dtype: torch.dtype,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def loop() -> None:
        everything_looped(monkeypatch)

    assert_loops_give_the_same_bits(function, dtype, tmp_path, FUNCTIONS[function], loop)


def test_what_goes_on_from_each_other_is_one_loop_with_one_array(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    everything_looped(monkeypatch)
    body = source_of(one_after_the_other).split("static void")[-1]
    assert body.count("for (int i") == 1
    assert body.count(f"[{SIZE}];") == 1


@pytest.mark.parametrize("length", [96, 101], ids="{} numbers".format)
def test_long_rows_are_added_up_in_c(length: int, tmp_path: Path) -> None:
    def sums(x: Tensor) -> Tensor:
        return (x.unsqueeze(-1) * torch.arange(length, dtype=x.dtype)).sum(-1)

    assert f"add_rows({length}, {SIZE}" in source_of(sums)
    x = normal(SIZE, seed=1)
    found = translated(sums, torch.float64, tmp_path)(x)
    torch.testing.assert_close(found, sums(x), rtol=1e-12, atol=1e-12)


def everything_looped(monkeypatch: pytest.MonkeyPatch) -> None:
    """Loops over as few numbers as there are."""
    monkeypatch.setattr(arrays, "LOOPED", 4)
    monkeypatch.setattr(arrays, "MANY", 4)
    monkeypatch.setattr(arrays, "OFTEN", 1)
