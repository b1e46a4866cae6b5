"""What the recordings of all tasks share."""

import numpy as np
import pytest
import torch

from aicon_baselines.evaluation.recording import to_array, true_intervals


@pytest.mark.parametrize(
    ("mask", "intervals"),
    [
        ([], []),
        ([0, 0], []),
        ([1, 1], [(0, 2)]),
        ([0, 1, 1, 0, 1], [(1, 3), (4, 5)]),
    ],
)
def test_true_intervals(mask: list[int], intervals: list[tuple[int, int]]) -> None:
    assert true_intervals(np.array(mask, dtype=bool)) == intervals


def test_arrays_are_doubles() -> None:
    array = to_array(torch.ones(2, dtype=torch.float32, requires_grad=True))
    assert array.dtype == np.float64
