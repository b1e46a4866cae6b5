"""Programmes of many bounds in C find what they do in torch, though sweeps pass over some rows."""

from pathlib import Path

import pytest
import torch
from _inputs import normal
from _inputs.translated import SIZE, translated
from torch import Tensor

from aicon_torch.export.codegen import has_compiler
from aicon_torch.safety import SafetyBounds, nearest_safe

pytestmark = pytest.mark.skipif(not has_compiler(), reason="there is no C compiler")

ROWS = 30

SLOPES, ROOT = normal(ROWS, SIZE // 2), normal(SIZE // 2, SIZE, seed=3)
LOWEST = -normal(ROWS, seed=1).abs() / SIZE


def safe(x: Tensor, inverse: Tensor | None, sweeps: int | None) -> Tensor:
    """The action and force with many bounds, of which the nominal action breaks more or fewer."""
    nominal, reach = x[..., : SIZE // 2], x[..., SIZE // 2 :].abs().sum(-1, keepdim=True)
    box = torch.full_like(nominal, 0.8)
    slopes = SLOPES.expand(*x.shape[:-1], *SLOPES.shape)
    within = SafetyBounds(slopes, LOWEST * reach, -box, box)
    found = nearest_safe(nominal, within, sweeps, inverse)
    return torch.cat((found.action, found.force), dim=-1)


@pytest.mark.parametrize("sweeps", [40, None], ids=["sweeps", "exactly"])
@pytest.mark.parametrize("inverse", [None, ROOT @ ROOT.mT], ids=["alike", "in a metric"])
def test_in_c_the_programme_finds_the_same(
    inverse: Tensor | None, sweeps: int | None, tmp_path: Path
) -> None:
    def function(x: Tensor) -> Tensor:
        return safe(x, inverse, sweeps)

    given = []
    for seed in range(20):
        for push in (0.0, 0.1, 1.0, 20.0):
            x = normal(SIZE, seed=seed)
            x[: SIZE // 2] *= push
            given.append(x)

    in_c = translated(function, torch.float64, tmp_path)
    for x, expected in zip(given, function(torch.stack(given)), strict=True):
        torch.testing.assert_close(in_c(x), expected, rtol=1e-9, atol=1e-12)
