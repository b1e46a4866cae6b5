"""The environments that an agent is trained in.

What an agent observes, each `stack` times, the oldest first:

| task | readings | AICON's |
|---|---|---|
| nav2d | `bearing` and `range`, noisy, in the world frame; `last_action` | the same; its memory holds the command |
| pusht | `environment_state`, 8 keypoints, and `agent_pos`, px; from them `offsets`; `last_action` | the same |

None sees a position or a map in navigation. In pushT the goal is not observed but always the same: an agent learns it
from the reward, AICON is told, and where the goal is elsewhere an agent cannot know.
"""

from typing import Any, cast

import gymnasium as gym
import stable_baselines3.common.vec_env as vec_env
from gymnasium import spaces
from stable_baselines3.common.monitor import Monitor

import aicon_envs  # noqa: F401  (registers the environments)
from aicon_baselines.agents.sb3.from_pusher import FromPusher
from aicon_baselines.agents.sb3.last_action import LAST_ACTION, LastAction
from aicon_baselines.agents.sb3.readings import is_bearing
from aicon_baselines.agents.sb3.settings import Settings
from aicon_baselines.agents.sb3.shaping import ShapedPush

_IDS = {"nav2d": "aicon/Nav2D-v0", "pusht": "aicon/PushT-v0"}


def make_training_env(config: Settings, seed: int) -> vec_env.VecEnv:
    """Build the environments that an agent is trained in, with stacked readings; `seed` is that of the first one."""
    envs: vec_env.VecEnv = vec_env.DummyVecEnv([lambda: _make_single(config)] * config.envs)
    envs.seed(seed)
    return vec_env.VecFrameStack(envs, config.stack) if config.stack > 1 else envs


def normalize(envs: vec_env.VecEnv, discount: float) -> vec_env.VecNormalize:
    """Normalise the reward and all readings but angles and the last action.

    The outermost wrapper: SAC's buffer holds what this one gets, so what is stacked outside of it would be lost.
    """
    names = [name for name in _spaces(envs) if not is_bearing(name) and name != LAST_ACTION]
    return vec_env.VecNormalize(envs, gamma=discount, norm_obs_keys=names)


def observed_shapes(envs: vec_env.VecEnv) -> dict[str, tuple[int, ...]]:
    """Return the shape of each reading before it is stacked."""
    return {name: space.shape or () for name, space in _spaces(envs.unwrapped).items()}


def _spaces(envs: vec_env.VecEnv) -> dict[str, spaces.Space[Any]]:
    return cast("spaces.Dict", envs.observation_space).spaces


def _make_single(config: Settings) -> Monitor[Any, Any]:
    env = gym.make(_IDS[config.task], max_episode_steps=config.horizon, disable_env_checker=True)
    if config.task == "pusht":
        env = ShapedPush(env, config.approach)
    if config.reach is not None:
        env = FromPusher(env, config.reach)
    return Monitor(LastAction(env))
