"""The reward of pushT in training."""

from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray


class ShapedPush(gym.Wrapper[Any, Any, Any, Any]):
    """PushT with a reward that is not the same everywhere far from the goal; for training only.

    r = (Φ' - Φ) / 100 px + 5 [success], with Φ = -e - w d before and Φ' after the step; e is the pose error
    `info["pose_error"]` and d the distance of the pusher to the nearest keypoint, both px. Undiscounted, an episode
    gives Φ at its end minus Φ at its start, / 100 px, + 5 if it ends in success, whatever lies between (A. Ng, D.
    Harada, S. Russell, ICML 1999). The environment's own reward, the coverage, is 0 until the object overlaps its goal,
    and pays for staying just below success.
    """

    def __init__(self, env: gym.Env[Any, Any], approach: float) -> None:
        """Wrap an environment that observes keypoints; `approach` is w."""
        super().__init__(env)
        self._approach = approach

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Start an episode."""
        observation, info = self.env.reset(seed=seed, options=options)
        self._potential = self._evaluate(observation, info)
        return observation, info

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Move by one control step."""
        observation, _, terminated, truncated, info = self.env.step(action)
        before, self._potential = self._potential, self._evaluate(observation, info)
        reward = (self._potential - before) / 100.0 + 5.0 * info["is_success"]
        return observation, reward, terminated, truncated, info

    def _evaluate(self, observation: dict[str, NDArray[Any]], info: dict[str, Any]) -> float:
        keypoints = observation["environment_state"].reshape(-1, 2)
        gap = np.linalg.norm(keypoints - observation["agent_pos"], axis=-1).min()
        return float(-info["pose_error"] - self._approach * gap)
