"""The evaluation task "panda_push": an arm that pushes an object to a pose, by its camera or with the true pose.

The environment's seed is the episode's seed. Repeats have other noise, start and target: a seed of their own.
"""

import math
from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode, SyncVectorEnv, VectorEnv

from aicon_baselines.evaluation.task import Episode, Measure, Task
from aicon_envs.panda_push import PandaPushEnv

# The arguments of the environment in each condition. Near the base the arm meets its joint limits and itself; far from
# it the arm becomes straight.
_ARGUMENTS: dict[str, dict[str, Any]] = {
    "camera": {},
    "true_pose": {"obs_type": "pose"},
    "half_mass": {"mass": 0.25},
    "double_mass": {"mass": 1.0},
    "half_friction": {"friction": 0.175},
    "more_friction": {"friction": 0.525},
    "object_L": {"object": "L"},
    "image_delay": {"image_delay": 0.1},
    "kick": {"kick_time": 10.0},
    "hard_kick": {"kick_time": 10.0, "kick_force": 6.0},
    "near_true_pose": {"area": ((0.36, 0.44), (-0.1, 0.1)), "obs_type": "pose"},
    "far_true_pose": {"area": ((0.62, 0.70), (-0.1, 0.1)), "obs_type": "pose"},
}


class _Frozen(gymnasium.Wrapper[Any, Any, Any, Any]):
    """An environment that stands still, in the dark, once its episode has ended, so that it costs no time."""

    def __init__(self, env: gymnasium.Env[Any, Any]) -> None:
        super().__init__(env)
        self._last: tuple[Any, Any, bool, bool, dict[str, Any]] | None = None

    def reset(self, **arguments: Any) -> tuple[Any, dict[str, Any]]:
        """Start an episode."""
        self._last = None
        return super().reset(**arguments)

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Move, or repeat what the episode ended with."""
        if self._last is not None:
            return self._last
        result = super().step(action)
        if result[2] or result[3]:
            observation = dict(result[0])
            if "rgb" in observation:
                observation["rgb"] = np.zeros_like(observation["rgb"])  # there is nothing more to look for
            self._last = (observation, *result[1:])
        return result


class _Episodes(SyncVectorEnv):
    """Environments side by side, of which some may have ended."""

    def step(self, actions: Any) -> Any:
        """Move those that have not ended."""
        self._autoreset_envs[:] = False  # gymnasium's own refuses to go on with the others
        return super().step(actions)


def _make_env(count: int, condition: str, horizon: int, **options: Any) -> VectorEnv[Any, Any, Any]:
    def make() -> gymnasium.Env[Any, Any]:
        env = PandaPushEnv(**{**_ARGUMENTS[condition], **options})
        return _Frozen(gymnasium.wrappers.TimeLimit(env, max_episode_steps=horizon))

    return _Episodes([make] * count, autoreset_mode=AutoresetMode.DISABLED)


def _reset_arguments(episodes: Sequence[Episode]) -> dict[str, Any]:
    return {"seed": [episode.noise_seed if episode.repeat else episode.seed for episode in episodes]}


def _policy_options(condition: str) -> dict[str, Any]:
    """Tell the policy its own body, its sensor and the object's outline, but neither mass nor friction."""
    from aicon_torch.models.panda_push.robot import Robot

    env = PandaPushEnv(**_ARGUMENTS[condition])
    corners = tuple((float(x), float(y)) for x, y in env.object.corners)
    sensing = "pose" if env.obs_type == "pose" else "camera"
    return {"robot": Robot.of(env.description()), "corners": corners, "sensing": sensing}


TASK = Task(
    name="panda_push",
    time_step=0.01,
    horizon=18_000,
    chunk_size=10,
    maps=("table",),
    conditions=tuple(_ARGUMENTS),
    make_env=_make_env,
    reset_arguments=_reset_arguments,
    policy_options=_policy_options,
    milestones=(6_000, 12_000),
    compiles=True,
    measures=(
        Measure("angle", "median angle at the end", "{:.1f}°", math.degrees(1.0)),
        Measure("limit_margin", "least distance to a joint's limit", "{:.3f} rad", least=True),
        Measure("self_distance", "least distance of the robot to itself", "{:.0f} mm", 1e3, least=True),
    ),
)
