"""The sum: plain backpropagation."""

import torch
from _inputs import RANDOM, for_each, resolved
from torch import Tensor

from aicon_torch import Sum


@for_each("stack", RANDOM)
def test_sum_adds(stack: Tensor) -> None:
    torch.testing.assert_close(resolved(Sum(), stack), stack.sum(-2))
