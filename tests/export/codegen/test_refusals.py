"""What would come out otherwise in C than in torch is refused by its name."""

import numpy as np
import pytest
import torch
import torch.nn.functional as F
from _inputs.translated import Function, source_of
from torch import Tensor

from aicon_torch.errors import GraphError

COUNTS = torch.zeros(12, dtype=torch.float64)


@torch.library.custom_op("aicon_tests::add", mutates_args=())
def subtracted(first: Tensor, second: Tensor) -> Tensor:
    """Another operator of a name that torch has as well."""
    return first - second


def counted(x: Tensor) -> Tensor:
    COUNTS.add_(1.0)
    return x + COUNTS.to(x.dtype)


def into_a_part(x: Tensor) -> Tensor:
    found = torch.zeros_like(x)
    torch.sum(x.reshape(3, 4), 0, out=found[:4])
    return found


def led_by_what_is_written(x: Tensor) -> Tensor:
    found = torch.zeros(3, dtype=x.dtype)
    found[0] = x.sum()
    return x if found[0] > 0 else -x


REFUSED: dict[str, tuple[Function, str]] = {
    # Types that C computes otherwise.
    "small integers": (lambda x: (1e9 * x).to(torch.int32) * 3, r"'_to_copy'.*torch\.int32"),
    "bytes": (lambda x: x.to(torch.uint8) + 250, r"'_to_copy'.*torch\.uint8"),
    "half precision": (lambda x: x.half() / 3, r"'_to_copy'.*torch\.float16"),
    "complex numbers": (lambda x: x.to(torch.complex128).abs(), "complex128"),
    "other numbers of the same bits": (lambda x: x.view(torch.int64), "'view'.*as torch.int64"),
    # Other operators, or other results of theirs.
    "a namesake": (lambda x: subtracted(x, 2 * x), "'aicon_tests::add'.*no translation"),
    "where the largest is": (
        lambda x: F.max_pool2d(x.view(1, 1, 3, 4), 2, return_indices=True)[1],
        "'max_pool2d_with_indices' cannot be exported: what is read of it",
    ),
    # What lasts longer than a step, or is somewhere else.
    "a count of its own": (counted, "'add_'.*a tensor that was there before the step"),
    "a result that is written elsewhere": (into_a_part, "'sum'.*out="),
    # A course that depends on values.
    "a branch on what is written": (led_by_what_is_written, "asks for the value"),
    "a comparison": (lambda x: x if torch.equal(x, x.abs()) else -x, "equal.*asks for the value"),
    "numpy": (lambda x: torch.from_numpy(np.sin(x.numpy())) + 0, r"Tensor\.numpy asks"),
    "numpy by itself": (lambda x: torch.as_tensor(np.asarray(x) + 1) + 0, r"__array__ asks"),
    "lists": (lambda x: torch.tensor(x.tolist()) + 0, r"Tensor\.tolist asks"),
    "how many": (lambda x: x * len((x > 0).nonzero()), "nonzero.*asks for the value"),
    "how many are chosen": (lambda x: x * x[x > 0].numel(), "index.*asks for the value"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_it_is_refused_by_its_name(name: str) -> None:
    function, words = REFUSED[name]
    with pytest.raises(GraphError, match=words):
        source_of(function)


def test_double_precision_within_single_precision_is_refused() -> None:
    with pytest.raises(GraphError, match=r"'_to_copy'.*torch\.float64.*torch\.float32"):
        source_of(lambda x: (x.double() + 1e9 - 1e9).float(), torch.float32)


def test_what_is_known_before_may_be_read_and_have_any_type() -> None:
    places, weights = torch.arange(12, dtype=torch.uint8), torch.ones(12).half()

    def weighted(x: Tensor) -> Tensor:
        return x[places.long()] * weights.to(x.dtype) * sum(weights.tolist())

    assert "static void f(" in source_of(weighted)
