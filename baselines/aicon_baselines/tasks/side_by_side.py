"""Environments without a vectorized form of their own, side by side as one."""

from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from gymnasium.wrappers import TimeLimit

_Step = tuple[Any, Any, bool, bool, dict[str, Any]]


def side_by_side(
    make_one: Callable[[], gymnasium.Env[Any, Any]], count: int, horizon: int
) -> "SideBySide":
    """Put environments side by side, as a task needs them.

    Args:
        make_one: Makes one of them.
        count: How many.
        horizon: Steps after which an episode ends. One that has ended stands still.
    """

    def make() -> gymnasium.Env[Any, Any]:
        return StandStillAfterEnd(TimeLimit(make_one(), max_episode_steps=horizon))

    return SideBySide([make] * count, autoreset_mode=AutoresetMode.DISABLED)


class StandStillAfterEnd(gymnasium.Wrapper[Any, Any, Any, Any]):
    """Stands still, in the dark, once its episode has ended, so that it costs no time."""

    def __init__(self, env: gymnasium.Env[Any, Any]) -> None:
        super().__init__(env)
        self._options: dict[str, Any] | None = None
        self._last: _Step | None = None

    def reset(self, **arguments: Any) -> tuple[Any, dict[str, Any]]:
        """Start an episode."""
        self._last = None
        if self._options is not None:
            arguments["options"], self._options = self._options, None
        return super().reset(**arguments)

    def leave_options(self, options: dict[str, Any]) -> None:
        """Leave options of its own for the next reset."""
        self._options = options

    def step(self, action: Any) -> _Step:
        """Move, or repeat what the episode ended with."""
        if self._last is not None:
            return self._last

        observation, reward, terminated, truncated, info = super().step(action)
        if terminated or truncated:
            at_rest = dict(observation)
            # A black image: there is nothing more to look for.
            if "rgb" in at_rest:
                at_rest["rgb"] = np.zeros_like(at_rest["rgb"])
            self._last = (at_rest, reward, terminated, truncated, info)
        return observation, reward, terminated, truncated, info


class SideBySide(SyncVectorEnv):
    """Environments side by side, of which some may have ended.

    The options of `reset` are for all of them, or `per_env` has a dictionary for each.
    """

    def reset(self, *, seed: Any = None, options: dict[str, Any] | None = None) -> Any:
        """Start their episodes."""
        if options is None or "per_env" not in options:
            return super().reset(seed=seed, options=options)

        for env, own in zip(self.envs, options["per_env"], strict=True):
            env.get_wrapper_attr("leave_options")(own)
        return super().reset(seed=seed)

    def step(self, actions: Any) -> Any:
        """Move those that have not ended."""
        # Gymnasium's own would refuse to go on with the others.
        self._autoreset_envs[:] = False
        return super().step(actions)
