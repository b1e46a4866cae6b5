"""The sweeps over many bounds in C find what those of torch do, though they pass over some rows."""

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


def safe(x: Tensor, push: float, in_metric: bool) -> Tensor:
    """The action and force with many bounds, of which the nominal action breaks more or fewer."""
    size = SIZE // 2
    nominal, reach = x[:size], x[size:].abs().sum()
    slopes, root = normal(ROWS, size).to(x), normal(size, size + 2, seed=3).to(x)
    bounds = -normal(ROWS, seed=1).abs().to(x) * reach / SIZE
    box = torch.full_like(nominal, 0.8)
    inverse = root @ root.mT if in_metric else None
    found = nearest_safe(push * nominal, SafetyBounds(slopes, bounds, -box, box), 40, inverse)
    return torch.cat((found.action, found.force))


@pytest.mark.parametrize("in_metric", [False, True])
@pytest.mark.parametrize("push", [0.0, 0.1, 1.0, 20.0])
def test_in_c_the_sweeps_find_the_same(push: float, in_metric: bool, tmp_path: Path) -> None:
    def function(x: Tensor) -> Tensor:
        return safe(x, push, in_metric)

    in_c = translated(function, torch.float64, tmp_path)
    for seed in range(20):
        x = normal(SIZE, seed=seed)
        torch.testing.assert_close(in_c(x), function(x), rtol=1e-9, atol=1e-12)
