"""What a rehearsal chooses among: the ways in which a policy can go on from a memory."""

from typing import Protocol, runtime_checkable

import torch
from torch import Tensor

from aicon_torch.control.memory import STEPS
from aicon_torch.dampers import PlaceEscape
from aicon_torch.errors import OptionError
from aicon_torch.policy import Policy
from aicon_torch.resolution import Memory
from aicon_torch.safety.bounds import safety_memory
from aicon_torch.safety.places import Places
from aicon_torch.validation import check_count, check_instance

EXPLORING = "/exploring"
"""How the key ends under which the memory has whether a quantity explores."""

TURNED = ("/average", "/tangent")
"""How the keys end of what says which way it goes on."""

ESCAPING = "/escape/escaping"
"""How the key ends under which the memory has whether an actuator makes a detour."""


@runtime_checkable
class Ways(Protocol):
    """Where there is something to decide, and among what."""

    def begins(self, memory: Memory, before: Memory | None, starts: Tensor | None) -> Tensor:
        """The rows ``(*B,)`` in which it is to be decided how to go on.

        Args:
            memory: The memory after a step.
            before: The memory before it; None where an episode begins in all rows.
            starts: The rows in which one begins; None for no row.
        """
        ...

    def of(self, memory: Memory, round: int) -> Memory:
        """The ways to go on, as memories ``(k, *B, …)``; those of round 0 begin with its own.

        Args:
            memory: The memory.
            round: How often none of the ways before has arrived.
        """
        ...


class WaysAlong:
    """Where a quantity explores: onward as it moved before, turned around, or no longer.

    It is decided when exploration begins, and every so many steps while it lasts.

    Args:
        policy: The policy.
        every: Number of these steps.

    Raises:
        OptionError: If it is none, explores nowhere, or is to decide in less than one step.
    """

    def __init__(self, policy: Policy, every: int = 50) -> None:
        self.policy, self.every = policy, every
        check_instance(self, ("policy",), Policy, "make_policy('nav2d')")
        check_count(self, ("every",), "number of steps", least=1)
        if not any(key.endswith(EXPLORING) for key in policy.backward_pass.keys):
            raise OptionError(
                "policy: it does not explore, so there is nothing to rehearse: expected a "
                "resolution with exploration, and a graph in which gradients meet."
            )

    def begins(self, memory: Memory, before: Memory | None, starts: Tensor | None) -> Tensor:
        """The rows ``(*B,)`` in which a quantity begins to explore, or has for a while."""
        begin = _begin(EXPLORING, memory, before, starts)
        explores = _flags(EXPLORING, memory).any(0)
        return begin | (explores & (memory[STEPS] % self.every == 0))

    def of(self, memory: Memory, round: int) -> Memory:
        """The memory, the memory turned around, and one that does not explore, ``(3, *B, …)``."""
        ways = {}
        for name, value in memory.items():
            turned = -value if name.endswith(TURNED) else value
            over = torch.zeros_like(value) if name.endswith(EXPLORING) else value
            ways[name] = torch.stack((value, turned, over))
        return ways


class OtherPlaces:
    """At the beginning, and where an actuator is held up: go on, or go to another place first.

    The actuator would go to the places of a sequence one by one
    (:class:`aicon_torch.safety.places.Places`). Each way begins with another one of them, and then
    the policy goes on as ever.

    Args:
        policy: The policy.
        count: To how many places it may go first.

    Raises:
        OptionError: If it is none, none of its actuators goes to places, or there is no place.
    """

    def __init__(self, policy: Policy, count: int = 31) -> None:
        self.policy, self.count = policy, count
        check_instance(self, ("policy",), Policy, "make_policy('reach', robot='arm.urdf')")
        check_count(self, ("count",), "number of places", least=1)
        self.places: dict[str, Places] = {}
        remembered = safety_memory(policy.model)  # none of an actuator without safety goals
        for name, actuator in policy.model.actuators.items():
            options = actuator.dampers.escape
            if f"{name}/escape/place" in remembered and isinstance(options, PlaceEscape):
                limits = torch.as_tensor(actuator.limit, dtype=policy.model.like.dtype)
                self.places[name] = Places(options, limits.expand(actuator.size), policy.model.dt)
        if not self.places:
            raise OptionError("policy: no actuator goes to places, so there are no other ones.")

    def begins(self, memory: Memory, before: Memory | None, starts: Tensor | None) -> Tensor:
        """The rows ``(*B,)`` that begin, or in which an actuator is held up."""
        held_up = _begin(ESCAPING, memory, before, starts)
        if before is None:
            return torch.ones_like(held_up)
        return held_up if starts is None else held_up | starts

    def of(self, memory: Memory, round: int) -> Memory:
        """The memory as it is, in round 0, and with each of the next places."""
        ways = {}
        for name, value in memory.items():
            ways[name] = torch.stack([value] * (self.count + 1))

        for name, places in self.places.items():
            start = f"{name}/escape/"
            own = {key[len(start) :]: value for key, value in ways.items() if key.startswith(start)}
            following = places.next_number(own)
            numbers = torch.arange(self.count + 1, device=following.device)
            numbers = numbers.reshape(-1, *[1] * (following.dim() - 1))
            number = following + numbers + round * (self.count + 1) - 1
            own = places.first_to(number, own)
            ways |= {start + key: value for key, value in own.items()}
        if round == 0:
            for name, value in memory.items():
                ways[name][0] = value
        return ways


def _begin(ending: str, memory: Memory, before: Memory | None, starts: Tensor | None) -> Tensor:
    """The rows ``(*B,)`` in which a flag is set now and was not before the step."""
    now = _flags(ending, memory)
    if before is None:
        return now.any(0)

    was = _flags(ending, before)
    if starts is not None:
        was = was & ~starts
    return (now & ~was).any(0)


def _flags(ending: str, memory: Memory) -> Tensor:
    """The flags whose keys end so, ``(k, *B)``.

    Raises:
        OptionError: If there is none: the memory is that of another policy.
    """
    names = sorted(name for name in memory if name.endswith(ending))
    if not names:
        raise OptionError(
            f"ways: no key of the memory ends with {ending!r}; expected the ways of the policy "
            "that is rehearsed."
        )
    return torch.stack([memory[name] for name in names])
