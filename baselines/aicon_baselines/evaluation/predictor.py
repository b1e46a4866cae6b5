"""What a policy has to offer to be compared."""

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray


class Predictor(Protocol):
    """Anything with the `predict` of stable-baselines3; B is the number of episodes in a batch.

    A policy that needs other observations than the task's usual ones, such as pictures, has an
    attribute `env_options`: arguments of the environment.
    """

    def predict(
        self,
        observation: dict[str, NDArray[Any]],
        state: Any = None,
        episode_start: NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[Any, Any]:
        """Choose the next actions.

        Args:
            observation: One array (B, n) per sensor, in the units of the environment.
            state: What the previous call returned second; None before the first step.
            episode_start: (B,), true where an episode begins: its part of `state` is forgotten.
            deterministic: Whether to take the action without sampling.

        Returns:
            The actions (B, m) in the units of the environment, and the state for the next call.
        """
        ...


def starting_rows(
    count: int, state: Any, episode_start: NDArray[np.bool_] | None
) -> NDArray[np.bool_]:
    """Which of B episodes begin, (B,): all before the first step, then those that are told.

    Args:
        count: B.
        state: See `Predictor.predict`.
        episode_start: See `Predictor.predict`; None where none begins.
    """
    if state is None:
        return np.ones(count, np.bool_)
    return np.zeros(count, np.bool_) if episode_start is None else np.asarray(episode_start)


Factory = Callable[[str], Predictor]
"""Builds a policy for a condition of its task; it can be pickled, since workers call it."""
