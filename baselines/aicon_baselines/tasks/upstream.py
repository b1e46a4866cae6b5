"""gym-pusht itself behind the interface of a comparison."""

from importlib.util import find_spec
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from numpy.typing import NDArray

from aicon_baselines.evaluation.errors import ComparisonError
from aicon_envs.pusht.goal import Goal
from aicon_envs.pusht.objects import OBJECTS
from aicon_envs.pusht import DEFAULT_GOAL

_GOAL = Goal(OBJECTS["T"], DEFAULT_GOAL)


class UpstreamPushT(VectorEnv[Any, Any, Any]):
    """B environments "gym_pusht/PushT-v0", each left alone once its episode has ended."""

    metadata = {"autoreset_mode": AutoresetMode.DISABLED}

    def __init__(
        self, num_envs: int, horizon: int, obs_type: str = "environment_state_agent_pos", **options: Any
    ) -> None:
        """Create the environments; `horizon` in steps, `obs_type` and other options are gym-pusht's."""
        if find_spec("gym_pusht") is None:
            raise ComparisonError("the condition 'upstream' needs gym-pusht: pip install 'aicon-torch[upstream]'")
        self.num_envs = num_envs
        self._envs = [
            gymnasium.make(
                "gym_pusht:gym_pusht/PushT-v0",
                obs_type=obs_type,
                max_episode_steps=horizon,
                disable_env_checker=True,
                **options,
            )
            for _ in range(num_envs)
        ]
        self._observations: list[dict[str, NDArray[np.float64]]] = []
        self._infos: list[dict[str, Any]] = []
        self._terminated = np.zeros(num_envs, np.bool_)
        self._truncated = np.zeros(num_envs, np.bool_)

    def reset(self, *, seed: Any = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Start all episodes from one seed each; options change nothing."""
        started = [env.reset(seed=each) for env, each in zip(self._envs, seed, strict=True)]
        self._observations, self._infos = map(list, zip(*started, strict=True))
        self._terminated[:] = self._truncated[:] = False
        return self._observe()

    def step(self, actions: NDArray[Any]) -> Any:
        """Step the environments whose episode goes on; rewards are left out."""
        for i in np.flatnonzero(~(self._terminated | self._truncated)):
            result = self._envs[i].step(np.asarray(actions[i], np.float32))
            self._observations[i], _, self._terminated[i], self._truncated[i], self._infos[i] = result
        observation, info = self._observe()
        return observation, np.zeros(self.num_envs), self._terminated.copy(), self._truncated.copy(), info

    def close_extras(self, **kwargs: Any) -> None:
        """Close the environments."""
        for env in self._envs:
            env.close()

    def _observe(self) -> tuple[dict[str, NDArray[np.float64]], dict[str, Any]]:
        observation = {name: np.stack([each[name] for each in self._observations]) for name in self._observations[0]}
        errors = [_GOAL.error(tuple(each["block_pose"])) for each in self._infos]
        info = {
            "is_success": np.array([each["is_success"] for each in self._infos]),
            "collision": np.zeros(self.num_envs, np.bool_),
            "position": np.stack([each["pos_agent"] for each in self._infos]),
            "distance": np.array(errors),
        }
        return observation, info
