"""The steepest path: the rule of the original AICON."""

import torch
from _inputs import RANDOM, for_each, lengths, resolved
from torch import Tensor

from aicon_torch import SteepestPath


@for_each("stack", RANDOM)
def test_steepest_path_takes_the_longest(stack: Tensor) -> None:
    longest = resolved(SteepestPath(), stack)

    torch.testing.assert_close(lengths(longest), lengths(stack).amax(-1))
    assert (longest.unsqueeze(-2) == stack).all(-1).any(-1).all()
