"""PushT as it looks from the pusher: where an action sends it, and where the keypoints are."""

from typing import Any, cast

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

Observation = dict[str, NDArray[Any]]

OFFSETS = "offsets"
"""The keypoints relative to the pusher, px: nothing that is not in the other readings."""

_WORLD_SIDE = 512.0  # px


class PusherFrame(gym.Wrapper[Any, Any, Any, Any]):
    """PushT whose action a in [-1, 1]² sends the pusher from its position p to p + reach a, px.

    The environment's own action is this target itself, clipped to the world: what a random agent
    does with it is to shuttle through the middle, and how it has to push depends on where it is.
    Likewise the keypoints are also observed relative to p, as `OFFSETS`.

    Args:
        env: An environment that observes keypoints.
        reach: Largest distance of a target along each axis, px.
    """

    def __init__(self, env: gym.Env[Any, Any], reach: float) -> None:
        super().__init__(env)
        self._reach = reach

        readings = cast("spaces.Dict", env.observation_space).spaces
        keypoints_shape = readings["environment_state"].shape
        offsets = spaces.Box(-np.inf, np.inf, keypoints_shape, np.float64)

        self.observation_space = spaces.Dict(dict(readings) | {OFFSETS: offsets})
        self.action_space = spaces.Box(-1.0, 1.0, (2,), np.float32)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Start an episode."""
        observation, info = self.env.reset(seed=seed, options=options)
        self._observation = add_offsets(observation)
        return self._observation, info

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Move by one control step."""
        target = target_of_action(action, self._observation, self._reach)
        observation, reward, terminated, truncated, info = self.env.step(target)

        self._observation = add_offsets(observation)
        return self._observation, reward, terminated, truncated, info


def add_offsets(observation: Observation) -> Observation:
    """Return an observation (*B, n) of pushT with `OFFSETS` as well."""
    keypoints, pusher = observation["environment_state"], observation["agent_pos"]
    pusher_per_keypoint = np.tile(pusher, keypoints.shape[-1] // 2)
    return observation | {OFFSETS: keypoints - pusher_per_keypoint}


def target_of_action(
    action: NDArray[Any], observation: Observation, reach: float
) -> NDArray[np.float32]:
    """Return the environment's action (*B, 2), px, for one of `PusherFrame`."""
    target = observation["agent_pos"] + reach * action
    return np.clip(target, 0.0, _WORLD_SIDE).astype(np.float32)
