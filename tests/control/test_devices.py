"""The same policy on another device."""

import pytest
import torch
from _inputs import drifting

from aicon_torch import make_policy


@pytest.mark.skipif(not torch.cuda.is_available(), reason="there is no CUDA device")
def test_cuda_gives_the_actions_of_the_cpu() -> None:
    here, there = make_policy("nav2d"), make_policy("nav2d").to("cuda")
    memory = other = None

    for readings in drifting(50, (3,)):
        moved = {key: value.to("cuda") for key, value in readings.items()}
        expected, memory = here.predict(readings, memory)
        action, other = there.predict(moved, other)

        torch.testing.assert_close(action.cpu(), expected, rtol=1e-6, atol=1e-8)
