"""Memories of policies: run, compared, and taken apart by rows."""

from collections.abc import Mapping, Sequence
from typing import Any

import torch
from torch import Tensor

from _asserts.roundings import assert_equal_but_for_roundings
from aicon_torch import ExportedPolicy, Policy
from aicon_torch.safety.watchdog import SENT

Memory = dict[str, Tensor]
Readings = Sequence[dict[str, Tensor]]


def rollout(policy: Policy, observations: Readings) -> list[Memory]:
    """The memory after each of some recorded readings."""
    memories: list[Memory] = []

    for observation in observations:
        _, memory = policy.predict(observation, memories[-1] if memories else None)
        memories.append(memory)

    return memories


def stacked(memories: Sequence[Mapping[str, Tensor]]) -> Memory:
    """Memories of several steps as one, along a new leading dimension.

    They are faster to compare.
    """
    return {name: torch.stack([memory[name] for memory in memories]) for name in memories[0]}


def assert_same_memory(
    first: Mapping[str, Tensor], second: Mapping[str, Tensor], tolerance: float
) -> None:
    """Two memories hold the same, to a tolerance."""
    assert first.keys() == second.keys()

    for name in first:

        def named(text: str, name: str = name) -> str:
            return f"{name}: {text}"

        torch.testing.assert_close(
            first[name], second[name], rtol=tolerance, atol=tolerance, msg=named
        )


def assert_same_steps(
    policy: Policy, other: Policy | ExportedPolicy, observations: Readings
) -> None:
    """Another form of a policy takes its steps, except for roundings.

    Step by step from the same memory, since roundings grow along a chaotic run.
    """
    (name,) = policy.model.actuators
    memory = None

    for observation in observations:
        action, found = other.predict(observation, memory)
        sent = found.get(name + SENT, found[name])
        assert torch.equal(torch.as_tensor(action), sent.to(torch.as_tensor(action)))
        memory = assert_equal_but_for_roundings(policy, observation, memory, found)


def assert_rows_stand_alone(policy: Policy, observations: Readings, rows: Sequence[Any]) -> None:
    """The rows of a batch ``(*B,)``, each by its number or numbers, take the steps of one alone.

    Compared in at most eight of the steps, from the memory of the batch, since roundings grow along
    a chaotic run.
    """
    every = -(-len(observations) // 8)
    before: Memory | None = None

    for step, observation in enumerate(observations):
        _, after = policy.predict(observation, before)

        if step % every == 0 or step == len(observations) - 1:
            for row in rows:
                alone = None if before is None else _row(before, row)
                assert_equal_but_for_roundings(
                    policy, _row(observation, row), alone, _row(after, row)
                )
        before = after


def _row(values: Mapping[str, Tensor], row: Any) -> Memory:
    return {name: value[row] for name, value in values.items()}


def arrived(policy: Policy, memory: Memory, quantity: str) -> Memory:
    """The gradients ``(*B, d)`` that arrived at a quantity in a step, by the path of each."""
    there = policy.trace(memory).quantities[quantity]
    return dict(zip(there.labels, there.gradients.unbind(-2), strict=True))
