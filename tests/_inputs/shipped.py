"""The shipped policies, as quick as a test can have them."""

import dataclasses
import functools
from typing import Any

from aicon_torch import Foresight, Policy, make_policy
from aicon_torch.export.codegen import has_compiler


@functools.cache
def lean(name: str, **options: Any) -> Policy:
    """A shipped policy with two gradients a step, for what holds however many there are.

    Ten times as quick as the shipped one, which takes twenty. A policy keeps nothing, so one serves
    all tests.
    """
    return lean_anew(name, **options)


def lean_anew(name: str, **options: Any) -> Policy:
    """The same, built where it is called."""
    policy = make_policy(name, **options)
    if isinstance(policy.law, Foresight) and policy.law.iterations > 2:
        law = dataclasses.replace(policy.law, iterations=2)
        return Policy(policy.model, policy.resolution, law, policy.perception)
    return policy


@functools.cache
def driven(name: str, **options: Any) -> Policy:
    """A shipped policy for what it does in a world, compiled where there is a C compiler."""
    return quick(make_policy(name, **options))


def quick(policy: Policy) -> Policy:
    """The policy, compiled where there is a C compiler."""
    return policy.compile() if has_compiler() else policy
