"""gym-pusht itself behind the interface of a comparison."""

from importlib.util import find_spec
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from numpy.typing import NDArray

from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.extras import pip_command
from aicon_envs.pusht import DEFAULT_GOAL, OBJECTS, Goal

_GOAL = Goal(OBJECTS["T"], DEFAULT_GOAL)


class UpstreamPushT(VectorEnv[Any, Any, Any]):
    """B environments "gym_pusht/PushT-v0", each left alone once its episode has ended."""

    metadata = {"autoreset_mode": AutoresetMode.DISABLED}

    def __init__(
        self,
        num_envs: int,
        horizon: int,
        obs_type: str = "environment_state_agent_pos",
        **options: Any,
    ) -> None:
        """Create the environments; `horizon` in steps, `obs_type` and others are gym-pusht's."""
        self.num_envs = num_envs
        self._envs: list[gymnasium.Env[Any, Any]] = []
        if find_spec("gym_pusht") is None:
            needed = pip_command("upstream")
            raise ComparisonError(f"the condition 'upstream' needs gym-pusht: {needed}")

        for _ in range(num_envs):
            env = gymnasium.make(
                "gym_pusht:gym_pusht/PushT-v0",
                obs_type=obs_type,
                max_episode_steps=horizon,
                disable_env_checker=True,
                **options,
            )
            self._envs.append(env)

        self._observations: list[dict[str, NDArray[np.float64]]] = []
        self._infos: list[dict[str, Any]] = []
        self._terminated = np.zeros(num_envs, np.bool_)
        self._truncated = np.zeros(num_envs, np.bool_)

    def reset(
        self, *, seed: Any = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Start all episodes from one seed each; options change nothing."""
        self._observations, self._infos = [], []
        for env, own_seed in zip(self._envs, seed, strict=True):
            observation, info = env.reset(seed=own_seed)
            self._observations.append(observation)
            self._infos.append(info)

        self._terminated[:] = self._truncated[:] = False
        return self._stack_observations(), self._stack_infos()

    def step(self, actions: NDArray[Any]) -> Any:
        """Step the environments whose episode goes on; rewards are left out."""
        for i in np.flatnonzero(~(self._terminated | self._truncated)):
            action = np.asarray(actions[i], np.float32)
            observation, _, terminated, truncated, info = self._envs[i].step(action)

            self._observations[i], self._infos[i] = observation, info
            self._terminated[i], self._truncated[i] = terminated, truncated

        return (
            self._stack_observations(),
            np.zeros(self.num_envs),
            self._terminated.copy(),
            self._truncated.copy(),
            self._stack_infos(),
        )

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """Return a picture of each, if `render_mode` is "rgb_array"."""
        pictures: list[Any] = [env.render() for env in self._envs]
        return None if pictures[0] is None else tuple(pictures)

    def close_extras(self, **kwargs: Any) -> None:
        """Close the environments."""
        for env in self._envs:
            env.close()

    def _stack_observations(self) -> dict[str, NDArray[np.float64]]:
        names = self._observations[0]
        return {name: np.stack([own[name] for own in self._observations]) for name in names}

    def _stack_infos(self) -> dict[str, Any]:
        """Return what a comparison reads; lengths in px."""
        distances = [_GOAL.error(tuple(own["block_pose"])) for own in self._infos]
        return {
            "is_success": np.array([own["is_success"] for own in self._infos]),
            "collision": np.zeros(self.num_envs, np.bool_),
            "position": np.stack([own["pos_agent"] for own in self._infos]),
            "distance": np.array(distances),
        }
