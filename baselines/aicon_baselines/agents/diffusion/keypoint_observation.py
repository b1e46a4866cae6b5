"""Pictures and keypoints in one observation."""

from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium import spaces

from aicon_envs.pusht import OBJECTS
from aicon_envs.pusht.geometry import place


class KeypointObservation(gym.ObservationWrapper[Any, Any, Any]):
    """PushT that observes pictures and, beside them, the object's keypoints (2N,), px.

    Args:
        env: An environment whose observations are dictionaries, and whose object is the T.
    """

    def __init__(self, env: gym.Env[Any, Any]) -> None:
        super().__init__(env)
        self._keypoints = OBJECTS["T"].keypoints
        self._pose: Any = None

        readings: Any = env.observation_space
        world = spaces.Box(0.0, 512.0, (2 * len(self._keypoints),), np.float64)
        self.observation_space = spaces.Dict({**readings.spaces, "environment_state": world})

    def reset(self, **arguments: Any) -> tuple[Any, dict[str, Any]]:
        """Start an episode."""
        observation, info = self.env.reset(**arguments)
        self._pose = info["block_pose"]
        return self.observation(observation), info

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Move by one control step."""
        observation, reward, terminated, truncated, info = self.env.step(action)
        self._pose = info["block_pose"]
        return self.observation(observation), reward, terminated, truncated, info

    def observation(self, observation: Any) -> Any:
        """Add the keypoints."""
        keypoints = place(self._keypoints, tuple(self._pose))
        return {**observation, "environment_state": keypoints.ravel()}
