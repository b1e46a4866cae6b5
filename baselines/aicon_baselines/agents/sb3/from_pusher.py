"""PushT as it looks from the pusher: what an agent's action means, and where the keypoints are from there."""

from typing import Any, cast

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

Observation = dict[str, NDArray[Any]]

OFFSETS = "offsets"
"""The keypoints relative to the pusher, px: nothing that is not in the other readings."""

_WORLD = 512.0  # px, side of the world of pushT


class FromPusher(gym.Wrapper[Any, Any, Any, Any]):
    """PushT whose action a in [-1, 1]² puts the controller's target at p + reach a, p the pusher's position, px.

    The environment's own action is the target itself, clipped to the world: what a random agent does with it is to
    shuttle through the middle, and how it has to push depends on where it is. Likewise the keypoints are observed
    relative to p as well, as `OFFSETS`.
    """

    def __init__(self, env: gym.Env[Any, Any], reach: float) -> None:
        """Wrap an environment that observes keypoints; `reach` in px."""
        super().__init__(env)
        readings = cast("spaces.Dict", env.observation_space).spaces
        offsets = spaces.Box(-np.inf, np.inf, readings["environment_state"].shape, np.float64)
        self.observation_space = spaces.Dict(dict(readings) | {OFFSETS: offsets})
        self.action_space = spaces.Box(-1.0, 1.0, (2,), np.float32)
        self._reach = reach

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Start an episode."""
        observation, info = self.env.reset(seed=seed, options=options)
        self._observation = with_offsets(observation)
        return self._observation, info

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Move by one control step."""
        result = self.env.step(to_target(action, self._observation, self._reach))
        self._observation = with_offsets(result[0])
        return self._observation, *result[1:]


def with_offsets(observation: Observation) -> Observation:
    """Return the observation (*B, n) of an environment of pushT with `OFFSETS`."""
    keypoints, pusher = observation["environment_state"], observation["agent_pos"]
    return observation | {OFFSETS: keypoints - np.tile(pusher, keypoints.shape[-1] // 2)}


def to_target(action: NDArray[Any], observation: Observation, reach: float) -> NDArray[np.float32]:
    """Return the environment's action (*B, 2), as `FromPusher` says."""
    return np.clip(observation["agent_pos"] + reach * action, 0.0, _WORLD).astype(np.float32)
