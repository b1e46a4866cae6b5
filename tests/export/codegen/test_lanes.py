"""What is the same in every row becomes a loop, and computes the same to the last bit."""

from collections.abc import Callable
from pathlib import Path

import pytest
import torch
from _asserts.loops import assert_loops_give_the_same_bits
from _inputs.translated import SIZE, source_of
from torch import Tensor

from aicon_torch.export.codegen import has_compiler, lanes

pytestmark = pytest.mark.skipif(not has_compiler(), reason="there is no C compiler")


def arithmetic(x: Tensor) -> Tensor:
    """Rows that share numbers, have constants and numbers of their own, and a result together."""
    rows = x.view(4, 3) * x[:3].exp() + torch.arange(4.0, dtype=x.dtype).view(4, 1)
    return (rows.sin() / (rows.square().sum(-1, keepdim=True) + 1.0)).sum(0)


def rows_picked(x: Tensor) -> Tensor:
    """Rows that begin with a place which is known when the program runs only."""
    places = x.topk(4, largest=False).indices
    taken = x.view(1, SIZE).expand(4, SIZE).gather(1, places.view(4, 1))
    return (taken * x).cos() * taken


def slopes(x: Tensor) -> Tensor:
    """One backward pass for some rows, as for the gaps of a safety goal."""
    copies = x.expand(4, SIZE).clone().requires_grad_()
    costs = copies[:, :3].norm(dim=-1) * copies.square().mean(-1).sqrt()
    weighted = costs * x[:4]
    return torch.autograd.grad(weighted.sum(), copies)[0]


def one_after_the_other(x: Tensor) -> Tensor:
    """Rows, what comes of them all, and rows again."""
    rows = (x.view(4, 3) + 1.0) * x[:3]
    together = rows.sum().tanh()
    return (x.view(4, 3) * together).exp() * rows


@pytest.mark.parametrize("function", [arithmetic, rows_picked, slopes, one_after_the_other])
@pytest.mark.parametrize(
    "dtype", [torch.float64, pytest.param(torch.float32, marks=pytest.mark.slow)], ids=str
)
def test_a_loop_over_rows_gives_the_same_bits(
    function: Callable[[Tensor], Tensor],
    dtype: torch.dtype,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def loop() -> None:
        monkeypatch.setattr(lanes, "FEWEST", 8)

    assert_loops_give_the_same_bits(function, dtype, tmp_path, "for (int row", loop)


def test_few_numbers_are_written_out() -> None:
    assert "for (int row" not in source_of(arithmetic)
