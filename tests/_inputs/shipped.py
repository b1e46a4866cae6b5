"""The shipped policies, as quick as a test can have them."""

import functools
from typing import Any

from aicon_torch import Foresight, Policy, make_policy
from aicon_torch.export.codegen import has_compiler


def lean(name: str, **options: Any) -> Policy:
    """A shipped policy with two gradients a step, for what holds however many there are.

    Ten times as quick as the shipped one, which takes twenty.
    """
    policy = make_policy(name, **options)
    if isinstance(policy.law, Foresight) and policy.law.iterations > 2:
        policy = make_policy(name, **options, **{"law.iterations": 2})
    return policy


@functools.cache
def driven(name: str, **options: Any) -> Policy:
    """A shipped policy for what it does in a world, compiled where there is a C compiler.

    A policy keeps nothing, so one serves all tests.
    """
    return quick(make_policy(name, **options))


def quick(policy: Policy) -> Policy:
    """The policy, compiled where there is a C compiler."""
    return policy.compile() if has_compiler() else policy
