"""The environments that an agent is trained in.

What an agent observes, each `stack` times, the oldest first:

| task | readings |
|---|---|
| nav2d | `bearing` and `range`, noisy, in the world frame; `last_action` |
| pusht | `environment_state` (keypoints), `agent_pos`, `offsets` between them, px; `last_action` |

AICON observes the same, but for the last action, which its memory holds. None sees a position or a
map in navigation. In pushT the goal is not observed but always the same: an agent learns it from
the reward, AICON is told, and where the goal is elsewhere an agent cannot know.
"""

from functools import partial
from typing import Any, cast

import gymnasium as gym
from gymnasium import spaces
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import DummyVecEnv, VecEnv, VecFrameStack, VecNormalize

import aicon_envs  # noqa: F401  (registers the environments)
from aicon_baselines.agents.sb3.algorithms import is_bearing
from aicon_baselines.agents.sb3.training_config import TrainingConfig
from aicon_baselines.agents.sb3.wrappers import LAST_ACTION, LastAction, PusherFrame, ShapedReward

_ENV_IDS = {"nav2d": "aicon/Nav2D-v0", "pusht": "aicon/PushT-v0"}


def make_training_envs(config: TrainingConfig, seed: int) -> VecEnv:
    """Build the environments that an agent is trained in, with stacked readings.

    Args:
        config: The training.
        seed: Seed of the first environment; the others count on from there.
    """
    envs: VecEnv = DummyVecEnv([partial(_make_env, config)] * config.envs)
    envs.seed(seed)

    return VecFrameStack(envs, config.stack) if config.stack > 1 else envs


def normalize(envs: VecEnv, discount: float) -> VecNormalize:
    """Normalise the reward and all readings but angles and the last action.

    The outermost wrapper: SAC's buffer holds what this one gets, so what is stacked outside of it
    would be lost.
    """
    names = [name for name in _readings(envs) if not is_bearing(name) and name != LAST_ACTION]
    return VecNormalize(envs, gamma=discount, norm_obs_keys=names)


def observed_shapes(envs: VecEnv) -> dict[str, tuple[int, ...]]:
    """Return the shape of each reading before it is stacked."""
    return {name: space.shape or () for name, space in _readings(envs.unwrapped).items()}


def _readings(envs: VecEnv) -> dict[str, spaces.Space[Any]]:
    return cast("spaces.Dict", envs.observation_space).spaces


def _make_env(config: TrainingConfig) -> Monitor[Any, Any]:
    env = gym.make(
        _ENV_IDS[config.task],
        max_episode_steps=config.horizon,
        disable_env_checker=True,
    )

    # The reward is that of the task's own readings, whatever the agent sees.
    if config.task == "pusht":
        env = ShapedReward(env, config.approach)
    if config.reach is not None:
        env = PusherFrame(env, config.reach)

    return Monitor(LastAction(env))
