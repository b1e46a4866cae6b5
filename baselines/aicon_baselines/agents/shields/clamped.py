"""A clamp: the simplest thing that may stand between a policy and a robot."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aicon_baselines.evaluation.predictor import Predictor


@dataclass(frozen=True)
class Clamped:
    """A policy whose actions are clamped to what is observed.

    Attributes:
        policy: Who proposes.
        clamp: What becomes of an action (B, 2), with the observation.
    """

    policy: Predictor
    clamp: Callable[[NDArray[Any], Mapping[str, Any]], NDArray[Any]]

    def predict(
        self, observation: dict[str, NDArray[Any]], *others: Any, **named: Any
    ) -> tuple[NDArray[Any], Any]:
        """The action (B, 2), in the policy's unit."""
        action, state = self.policy.predict(observation, *others, **named)
        return self.clamp(action, observation), state


def shortened(action: NDArray[Any], longest: float | NDArray[Any]) -> NDArray[Any]:
    """Actions (B, n), those that are longer than a length (B, 1) brought to it."""
    length = np.linalg.norm(action, axis=-1, keepdims=True)
    result: NDArray[Any] = action * np.minimum(1.0, longest / np.maximum(length, 1e-9))
    return result
