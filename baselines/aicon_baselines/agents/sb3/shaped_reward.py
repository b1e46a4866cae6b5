"""The reward of pushT in training."""

from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

_LENGTH_UNIT = 100.0  # px; a reward of 1 for coming so much closer
_SUCCESS_REWARD = 5.0


class ShapedReward(gym.Wrapper[Any, Any, Any, Any]):
    """PushT with a reward that says the way also far from the goal; for training only.

    r = (Φ' - Φ) / 100 px + 5 [success], with Φ = -e - w d before and Φ' after the step; e is the
    pose error `info["pose_error"]` and d the distance of the pusher to the nearest keypoint, both
    px. Undiscounted, an episode gives Φ at its end minus Φ at its start, / 100 px, + 5 if it ends
    in success, whatever lies between: potential-based shaping (A. Ng, D. Harada, S. Russell, ICML
    1999). The environment's own reward, the coverage, is 0 until the object overlaps its goal, and
    pays for staying just below success.

    Args:
        env: An environment that observes keypoints.
        approach: The weight w of the pusher's way to the object.
    """

    def __init__(self, env: gym.Env[Any, Any], approach: float) -> None:
        super().__init__(env)
        self._approach = approach

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Start an episode."""
        observation, info = self.env.reset(seed=seed, options=options)
        self._potential = self._evaluate_potential(observation, info)
        return observation, info

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Move by one control step."""
        observation, _, terminated, truncated, info = self.env.step(action)

        previous_potential = self._potential
        self._potential = self._evaluate_potential(observation, info)

        progress = (self._potential - previous_potential) / _LENGTH_UNIT
        reward = progress + _SUCCESS_REWARD * info["is_success"]
        return observation, reward, terminated, truncated, info

    def _evaluate_potential(
        self, observation: dict[str, NDArray[Any]], info: dict[str, Any]
    ) -> float:
        """Return Φ, px."""
        keypoints = observation["environment_state"].reshape(-1, 2)
        distances = np.linalg.norm(keypoints - observation["agent_pos"], axis=-1)
        return float(-info["pose_error"] - self._approach * distances.min())
