"""Actions, episodes and settings for the tests of the pushT environment."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aicon_envs.pusht import PushTEnv

ID = "aicon/PushT-v0"
OBS_TYPES = ("environment_state_agent_pos", "state", "pixels", "pixels_agent_pos")
GOAL = (256.0, 256.0, math.pi / 4.0)

APART = [40.0, 40.0, 300.0, 200.0, 0.3]
"""A state in which nothing touches."""

DISTURBED: Any = {
    "goal_pose": "random",
    "observe_goal": True,
    "action_noise": 2.0,
    "goal_jumps": 2,
    "kick_interval": 7,
}


def random_actions(steps: int, *shape: int, seed: int = 0) -> NDArray[np.float32]:
    rng = np.random.default_rng(seed)
    return rng.uniform(0.0, 512.0, size=(steps, *shape, 2)).astype(np.float32)


def push(info: dict[str, Any], noise: NDArray[np.float64]) -> NDArray[np.float32]:
    """A target near the object's frame: the pusher runs into the object from all sides."""
    near_object = info["block_pose"][:2] + 60.0 * noise
    target: NDArray[np.float32] = near_object.clip(0.0, 512.0).astype(np.float32)
    return target


def pushes(steps: int, seed: int = 0) -> NDArray[np.float64]:
    return np.random.default_rng(seed).normal(size=(steps, 2))


def rollout(env: PushTEnv, steps: int = 30, **reset: Any) -> list[Any]:
    """Return all results of an episode: of the reset, then observation, reward, end and info."""
    observation, info = env.reset(**reset)
    record: list[Any] = [observation, info]

    for noise in pushes(steps):
        observation, reward, terminated, _, info = env.step(push(info, noise))
        record += [observation, reward, terminated, info]

    return record
