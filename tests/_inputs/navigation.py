"""The navigation's policies, and readings to run them on."""

import dataclasses
import functools
from collections.abc import Mapping
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from _inputs.random_numbers import normal
from _inputs.rules import exploration_in_paper
from _inputs.shipped import lean
from aicon_torch import Goal, Policy


@functools.cache
def navigation(preset: str = "aicon") -> Policy:
    """One of the navigation's policies, with two gradients a step where twenty are shipped."""
    return lean("nav2d", preset=preset)


def with_rule(policy: Policy, **options: Any) -> Policy:
    """The policy with some options of its resolution changed."""
    rule: Any = policy.resolution
    return Policy(policy.model, dataclasses.replace(rule, **options), policy.law)


def with_law(policy: Policy, **options: Any) -> Policy:
    """The policy with some options of its action law changed."""
    return Policy(policy.model, policy.resolution, dataclasses.replace(policy.law, **options))


@functools.cache
def navigation_in_text() -> Policy:
    """The navigation's policy with conflicts as the text has them.

    The dominant gradient is compared with the second strongest, by weights.
    """
    ours: Any = navigation().resolution
    exploration = exploration_in_paper(escape=ours.exploration.escape)
    return with_rule(navigation(), relative=False, exploration=exploration)


def with_goal(goal: Goal) -> Policy:
    """The navigation's policy with a goal more, its modules untouched."""
    return navigation().with_goal(goal)


def drifting(steps: int, batch: tuple[int, ...] = (), seed: int = 0) -> list[dict[str, Tensor]]:
    """Readings of an agent that comes near an obstacle again and again.

    The clearance swings, the bearing wanders.
    """
    time = 0.05 * torch.arange(steps, dtype=torch.float64)
    time = time.reshape(-1, *(1,) * (len(batch) + 1))
    phase = normal(*batch, seed=seed).unsqueeze(-1)

    bearing = (0.05 * normal(steps, *batch, 1, seed=seed + 1)).cumsum(0) + phase
    clearance = 0.35 + 0.3 * torch.cos(1.3 * time + phase)
    clearance = clearance + 0.01 * normal(steps, *batch, 1, seed=seed + 2)

    return [{"bearing": bearing[i], "range": clearance[i]} for i in range(steps)]


def observation_with(**changes: Any) -> dict[str, Any]:
    """A plain observation in numpy, with some of its readings changed."""
    return {"bearing": np.array([0.3]), "range": np.array([1.0])} | changes


def as_arrays(observation: Mapping[str, Tensor]) -> dict[str, NDArray[Any]]:
    """The same observation in numpy."""
    return {name: reading.numpy() for name, reading in observation.items()}
