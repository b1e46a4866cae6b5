"""Changing the rule for gradients in conflict in the middle of an episode."""

from collections.abc import Mapping

from aicon_torch import NullspaceProjection, Policy, Resolution, SteepestPath, Sum
from aicon_torch.resolution import Memory

_KINDS: Mapping[str, type[Resolution]] = {
    "nullspace projection": NullspaceProjection,
    "sum": Sum,
    "steepest path": SteepestPath,
}


def resolutions_of(policy: Policy) -> dict[str, Resolution]:
    """The resolutions that a view offers for a policy: its own first, with its own options."""
    own = policy.resolution
    name = type(own).__name__
    for title, kind in _KINDS.items():
        if type(own) is kind:
            name = title

    offered = {name: own}
    for title, kind in _KINDS.items():
        offered.setdefault(title, kind())
    return offered


def with_resolution(policy: Policy, resolution: Resolution) -> Policy:
    """The same policy with another resolution."""
    return Policy(policy.model, resolution, policy.law, policy.perception)


def carried_over(policy: Policy, memory: Memory, fresh: Memory) -> Memory:
    """The memory of a policy as one that differs in its resolution goes on with it.

    Estimates, covariances, actions and the goals' factors are those of the memory. What a
    resolution remembers where gradients met is its own affair, and begins anew.

    Args:
        policy: The policy that returned the memory.
        memory: Its memory.
        fresh: A memory of the other policy, of the same batch.
    """
    meetings = tuple(f"{name}/" for name in policy.trace(memory).quantities)
    kept = {}
    for key in fresh.keys() & memory.keys():
        if not key.startswith(meetings):
            kept[key] = memory[key]
    return fresh | kept
