"""The same policy on another device."""

import copy

import pytest
import torch
from _inputs import drifting

from aicon_torch import Goal, make_policy


@pytest.mark.skipif(not torch.cuda.is_available(), reason="there is no CUDA device")
def test_cuda_gives_the_actions_of_the_cpu() -> None:
    here, there = make_policy("nav2d"), make_policy("nav2d").to("cuda")
    memory = other = None

    for readings in drifting(50, (3,)):
        moved = {key: value.to("cuda") for key, value in readings.items()}
        expected, memory = here.predict(readings, memory)
        action, other = there.predict(moved, other)

        torch.testing.assert_close(action.cpu(), expected, rtol=1e-6, atol=1e-8)


@pytest.mark.skipif(not torch.cuda.is_available(), reason="there is no CUDA device")
def test_what_is_added_to_a_policy_comes_to_its_device() -> None:
    here, there = make_policy("nav2d"), make_policy("nav2d").to("cuda")
    dry = Goal("dry", lambda p_tar: p_tar.norm(dim=-1))
    grown = [policy.with_goal(copy.deepcopy(dry)) for policy in (here, there)]
    readings = drifting(1, (3,))[0]
    moved = {key: value.to("cuda") for key, value in readings.items()}

    for policy in (there, grown[1]):
        assert all(value.is_cuda for value in policy.buffers())
        action, _ = policy.predict(moved)
        assert action.is_cuda
    torch.testing.assert_close(action.cpu(), grown[0].predict(readings)[0], rtol=1e-6, atol=1e-8)
