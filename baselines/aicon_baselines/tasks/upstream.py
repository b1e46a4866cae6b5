"""gym-pusht itself behind the interface of a comparison."""

from typing import Any

import gymnasium
import numpy as np

from aicon_baselines.extras import require
from aicon_envs.pusht import DEFAULT_GOAL, OBJECTS, Goal

_GOAL = Goal(OBJECTS["T"], DEFAULT_GOAL)


class UpstreamPushT(gymnasium.Wrapper[Any, Any, Any, Any]):
    """The environment "gym_pusht/PushT-v0", which says what a comparison reads."""

    def __init__(self, obs_type: str = "environment_state_agent_pos", **options: Any) -> None:
        """Create it; the arguments are gym-pusht's.

        Raises:
            ComparisonError: If it is not installed.
        """
        require("the condition 'upstream'", "upstream", "gym_pusht")
        name = "gym_pusht:gym_pusht/PushT-v0"
        super().__init__(
            gymnasium.make(
                name,
                obs_type=obs_type,
                max_episode_steps=-1,  # the task ends episodes
                disable_env_checker=True,
                **options,
            )
        )

    def reset(self, *, seed: Any = None, options: Any = None) -> tuple[Any, dict[str, Any]]:
        """Start an episode; options change nothing."""
        observation, info = self.env.reset(seed=seed)
        return observation, _told(info)

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Take a step."""
        action = np.asarray(action, np.float32)
        observation, reward, terminated, truncated, info = self.env.step(action)
        return observation, reward, terminated, truncated, _told(info)


def _told(info: dict[str, Any]) -> dict[str, Any]:
    """What a comparison reads; lengths in px."""
    return {
        "is_success": bool(info["is_success"]),
        "collision": False,
        "position": np.asarray(info["pos_agent"], np.float64),
        "distance": _GOAL.error(tuple(info["block_pose"])),
    }
