"""Choices that are made when the program runs come out as torch makes them."""

from pathlib import Path

import pytest
import torch
from _inputs import normal
from _inputs.translated import SIZE, Function, translated
from torch import Tensor

from aicon_torch.export.codegen import arrays, has_compiler
from aicon_torch.export.codegen.scalars import Program

pytestmark = pytest.mark.skipif(not has_compiler(), reason="there is no C compiler")


def picked(x: Tensor) -> Tensor:
    """Of two candidates, of many, and of many that are the same."""
    index, place = x[:2].argmax(0, keepdim=True), x.argmin(0, keepdim=True)
    return torch.cat((x.gather(0, index), x.gather(0, place), x[:1].expand(SIZE).gather(0, place)))


def the_first_of_many(x: Tensor) -> Tensor:
    """Of so many that a loop picks them, some equal: in order, their places, and the first ones."""
    many = torch.cat((x, x.flip(0), x))
    down, up = many.sort(stable=True, descending=True), many.sort(stable=True)
    few, largest, smallest = (
        x.sort().values,
        many.topk(5).values,
        many.topk(5, largest=False).values,
    )
    return torch.cat((*down, *up, few, largest, smallest))


def first_and_last(x: Tensor) -> Tensor:
    """Where the largest and the smallest are, and all from the largest down."""
    places = torch.stack((x.argmax(), x.argmin()))
    return torch.cat((places.to(x.dtype), x.sort(descending=True).values))


def test_one_of_many_readings_is_picked_where_they_stand(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As of a map that is a reading: they are an array already, and longer than what is asked."""
    monkeypatch.setattr(arrays, "LOOPED", 4)

    def found(x: Tensor) -> Tensor:
        return x[:SIZE].gather(0, x.argmax(0, keepdim=True)) + x[:5].gather(0, x[:5].argsort())

    for seed in range(3):
        x = normal(SIZE, seed=seed)
        torch.testing.assert_close(translated(found, torch.float64, tmp_path)(x), found(x))


@pytest.mark.parametrize("function", [picked, first_and_last, the_first_of_many])
@pytest.mark.parametrize("count", [0, 1, 2, SIZE], ids="{} missing".format)
def test_missing_numbers_come_first_as_in_torch(
    function: Function, count: int, tmp_path: Path
) -> None:
    x = normal(SIZE, seed=1)
    x[torch.randperm(SIZE, generator=torch.Generator().manual_seed(count))[:count]] = torch.nan
    found = translated(function, torch.float64, tmp_path)(x)
    torch.testing.assert_close(found, function(x), rtol=0, atol=0, equal_nan=True)


def test_a_known_truth_value_takes_no_operation() -> None:
    program = Program(torch.float64)
    unknown = program.apply("lt", (program.input("x", 0), program.input("x", 1)), "bool")
    for operation, decisive in (("and", False), ("or", True)):
        neutral = program.constant(not decisive, "bool")
        decided = program.constant(decisive, "bool")
        assert program.apply(operation, (unknown, neutral), "bool") is unknown
        assert program.apply(operation, (decided, unknown), "bool") is decided
