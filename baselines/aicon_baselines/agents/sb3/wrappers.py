"""Environments as an agent sees them in training: its reward, its frame and its last action."""

from typing import Any, cast

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from aicon_baselines.evaluation.errors import ComparisonError

LAST_ACTION = "last_action"
"""The action that the agent took last, in its own units; zero at the start of an episode."""

OFFSETS = "offsets"
"""The keypoints relative to the pusher, px: nothing that is not in the other readings."""

_WORLD_SIDE = 512.0  # px
_LENGTH_UNIT = 100.0  # px; a reward of 1 for coming so much closer
_SUCCESS_REWARD = 5.0

Observation = dict[str, NDArray[Any]]


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

    def reset(self, **arguments: Any) -> tuple[Any, dict[str, Any]]:
        """Start an episode."""
        observation, info = self.env.reset(**arguments)
        return observation | {LAST_ACTION: self._no_action}, info

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Move by one control step."""
        observation, reward, terminated, truncated, info = self.env.step(action)
        return observation | {LAST_ACTION: action}, reward, terminated, truncated, info


class PusherFrame(gym.ObservationWrapper[Any, Any, Any]):
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

    def observation(self, observation: Observation) -> Observation:
        """Observe the keypoints relative to the pusher as well."""
        self._observation = add_offsets(observation)
        return self._observation

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Move by one control step."""
        return super().step(target_of_action(action, self._observation, self._reach))


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

    def reset(self, **arguments: Any) -> tuple[Any, dict[str, Any]]:
        """Start an episode."""
        observation, info = self.env.reset(**arguments)
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
