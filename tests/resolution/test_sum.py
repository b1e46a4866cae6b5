"""The sum: plain backpropagation."""

import pytest
import torch
from _inputs import RANDOM, resolved
from torch import Tensor

from aicon_torch import Sum


@pytest.mark.parametrize("stack", RANDOM.values(), ids=RANDOM.keys())
def test_sum_adds(stack: Tensor) -> None:
    torch.testing.assert_close(resolved(Sum(), stack), stack.sum(-2))
