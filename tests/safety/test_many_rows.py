"""Sweeps over many bounds are one operation, which does what the sweeps written out do."""

import pytest
import torch
from _inputs import normal

from aicon_torch.safety import SafetyBounds, nearest_safe, quadratic_programme


@pytest.mark.parametrize("in_metric", [False, True])
@pytest.mark.parametrize("batch", [(), (5,), (2, 3)])
def test_one_operation_is_the_sweeps_written_out(
    monkeypatch: pytest.MonkeyPatch, in_metric: bool, batch: tuple[int, ...]
) -> None:
    size, rows = 4, 30
    nominal, slopes, root = normal(*batch, size), normal(*batch, rows, size), normal(size, 6)
    box = torch.full_like(nominal, 0.8)
    within = SafetyBounds(slopes, -normal(*batch, rows, seed=1).abs(), -box, box)
    inverse = (root @ root.mT).expand(*batch, size, size) if in_metric else None

    together = nearest_safe(2 * nominal, within, 12, inverse)
    monkeypatch.setattr(quadratic_programme, "MOST_UNROLLED", 12 * rows)
    written_out = nearest_safe(2 * nominal, within, 12, inverse)

    assert not torch.equal(written_out.action, nominal)
    torch.testing.assert_close(together, written_out)
