"""Commands: what the robot gets for an action."""

import numpy as np
import torch
from _asserts import assert_same_memory
from _inputs import as_arrays, slower, steered, walled, where_to
from torch import Tensor

from aicon_torch.export.codegen import has_compiler


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


def test_before_the_first_readings_no_command_is_to_be_sent() -> None:
    policy = steered(command=where_to)
    (reading,) = walled(1, (2,))
    unseen = torch.tensor([[1.0], [torch.nan]], dtype=torch.float64)
    _, memory = policy.predict(reading | {"z": unseen * reading["z"]})
    assert "send 'a' no command" in str(policy.explain(memory, row=1))
    assert "send 'a' no command" not in str(policy.explain(memory, row=0))


def test_a_command_may_have_another_size() -> None:
    def polar(a: Tensor) -> Tensor:
        return torch.cat((a, a.norm(dim=-1, keepdim=True)), dim=-1)

    for batch in ((), (4,)):
        (reading,) = walled(1, batch)
        command, memory = steered(command=polar).predict(reading)
        torch.testing.assert_close(command, polar(memory["a"]))


def test_no_command_is_beyond_its_range() -> None:
    policy, memory = steered(command=where_to, command_range=(-0.05, 0.05)), None
    for reading in walled(5):
        command, memory = policy.predict(reading, memory)
        assert command.abs().max() == 0.05
        assert torch.equal(memory["a.sent"], command)


def test_nor_is_the_last_one_that_somebody_has_changed_in_the_memory() -> None:
    """At rest it is sent again."""
    policy = steered(command=where_to, command_range=(-5.0, 5.0), max_age=0.1)
    _, memory = policy.predict(walled(1)[0])
    gone = {"z": torch.full((2,), torch.nan, dtype=torch.float64), "wall": torch.ones(1)}
    for _ in range(4):
        resting, memory = policy.predict(gone, memory)
    assert torch.equal(policy.predict(gone, memory)[0], resting)

    for form in (policy, *[policy.compile()] * has_compiler()):
        command, _ = form.predict(gone, memory | {"a.sent": torch.tensor([7e5, -1.0]).double()})
        assert command.tolist() == [5.0, -1.0]
