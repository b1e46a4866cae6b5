"""What is compared in a world: who proposes, what guards, in which episodes."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from aicon_baselines.evaluation.predictor import Predictor

Guard = Callable[[Predictor], Predictor]
"""What is put around a policy."""


class World(NamedTuple):
    """What is compared in a world.

    Attributes:
        proposers: How each policy is made, by name.
        guards: What is put around it, by name.
        start: From the first seed and a number, so many episodes and how they start.
        time_step: Of the policies, s.
        still: An episode is stuck where it stays for so many steps within so far, in the unit of
            ``info["position"]``.
        longest: An action that is longer is as good as one of this length.
        ends_at_touch: Whether a collision ends an episode.
        at_once: Episodes side by side; an arm in MuJoCo takes 0.1 GB.
    """

    proposers: Mapping[str, Callable[[], Predictor]]
    guards: Mapping[str, Guard]
    start: Callable[[int, int], tuple[Any, Any]]
    time_step: float
    still: tuple[int, float]
    longest: float = np.inf
    ends_at_touch: bool = False
    at_once: int = 1000


def guards(clamp: Guard, shielded: Callable[..., Predictor]) -> dict[str, Guard]:
    """Nothing, a clamp, the bounds of a shield alone, and the shield."""
    return {
        "nothing": lambda policy: policy,
        "clamp": clamp,
        "bounds alone": lambda policy: shielded(policy, goes_around=False),
        "shield": shielded,
    }


def seeded(make_env: Callable[[int], Any]) -> Callable[[int, int], tuple[Any, Any]]:
    """Episodes of environments that hang on their seeds alone."""

    def start(first: int, count: int) -> tuple[Any, Any]:
        env = make_env(count)
        return env, env.reset(seed=list(range(first, first + count)))

    return start
