"""The steepest path: the rule of the original AICON."""

import pytest
import torch
from _inputs import RANDOM, lengths, resolved
from torch import Tensor

from aicon_torch import SteepestPath


@pytest.mark.parametrize("stack", RANDOM.values(), ids=RANDOM.keys())
def test_steepest_path_takes_the_longest(stack: Tensor) -> None:
    longest = resolved(SteepestPath(), stack)

    torch.testing.assert_close(lengths(longest), lengths(stack).amax(-1))
    assert (longest.unsqueeze(-2) == stack).all(-1).any(-1).all()
