"""An agent sees the action that it took last."""

from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium import spaces

from aicon_baselines.evaluation.errors import ComparisonError

LAST_ACTION = "last_action"
"""The action that the agent took last, in its own units; zero at the start of an episode."""


class LastAction(gym.Wrapper[Any, Any, Any, Any]):
    """An environment that also observes the last action, as AICON's estimators know their command.

    Without it, how a clearance changed says nothing about where the obstacle is.

    Args:
        env: An environment with dictionaries of observations and continuous actions.
    """

    def __init__(self, env: gym.Env[Any, Any]) -> None:
        super().__init__(env)

        readings, actions = env.observation_space, env.action_space
        if not isinstance(readings, spaces.Dict) or not isinstance(actions, spaces.Box):
            raise ComparisonError(
                f"expected observations Dict and actions Box, got {readings} and {actions}"
            )

        self.observation_space = spaces.Dict(dict(readings.spaces) | {LAST_ACTION: actions})
        self._no_action = np.zeros(actions.shape, actions.dtype)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Start an episode."""
        observation, info = self.env.reset(seed=seed, options=options)
        return observation | {LAST_ACTION: self._no_action}, info

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Move by one control step."""
        observation, reward, terminated, truncated, info = self.env.step(action)
        return observation | {LAST_ACTION: action}, reward, terminated, truncated, info
