"""Commands: what the robot gets for an action."""

import numpy as np
import torch
from _asserts import assert_same_memory
from _inputs import as_arrays, slower, steered, walled, where_to
from torch import Tensor


def test_the_memory_holds_the_constrained_action_and_the_robot_gets_the_command() -> None:
    """The action is what the estimates go on with; the command is what is sent."""
    policy, plain = steered([slower], where_to), steered([slower])
    memory = other = None

    for reading in walled(5):
        command, memory = policy.predict(reading, memory)
        action, other = plain.predict(reading, other)
        sent = memory.pop("a.sent")
        assert_same_memory(memory, other, 0.0)
        memory["a.sent"] = sent
        assert torch.equal(sent, command)
        assert torch.equal(memory["a"], action) and memory["a"].norm() <= 1.0
        torch.testing.assert_close(command, memory["x"] + 0.1 * action)


def test_commands_are_of_the_kind_of_the_observation() -> None:
    policy = steered([slower], where_to)
    (reading,) = walled(1)

    command, memory = policy.predict(as_arrays(reading))
    assert isinstance(command, np.ndarray) and command.dtype == np.float32

    expected, remembered = policy.predict(reading)
    assert isinstance(expected, Tensor) and expected.dtype == torch.float64
    assert np.array_equal(command, expected.numpy().astype(np.float32))
    assert_same_memory(memory, remembered, 0.0)

    assert np.array_equal(policy.act(as_arrays(reading)), command)


def test_a_command_may_have_another_size() -> None:
    def polar(a: Tensor) -> Tensor:
        return torch.cat((a, a.norm(dim=-1, keepdim=True)), dim=-1)

    for batch in ((), (4,)):
        (reading,) = walled(1, batch)
        command, memory = steered(command=polar).predict(reading)
        torch.testing.assert_close(command, polar(memory["a"]))
