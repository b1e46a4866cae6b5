"""Many pushT environments in one process."""

from collections.abc import Callable, Sequence
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.error import ResetNeeded
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space, concatenate, create_empty_array
from numpy.typing import NDArray

from aicon_envs.checks import check_action, copy_options
from aicon_envs.pusht.environment import PushTEnv
from aicon_envs.pusht.spaces import MEANING, Action, Observation
from aicon_envs.vectorized import (
    BoolArray,
    check_autoreset_mode,
    check_count,
    check_reset_mask,
    split_options,
    split_seed,
)

Wrapper = Callable[[gym.Env[Any, Any]], gym.Env[Any, Any]]

_INFO_KEYS = (
    "is_success",
    "coverage",
    "block_pose",
    "goal_pose",
    "pos_agent",
    "vel_agent",
    "n_contacts",
    "pose_error",
)


class PushTVectorEnv(VectorEnv[Observation, Action, NDArray[Any]]):
    """N copies of `PushTEnv`, stepped one after the other.

    ## Description
    Each gives, number for number, the same trajectory as a single environment with the same seed
    and actions.

    ## Observation space
    That of `PushTEnv` with arrays (N, ...).

    ## Action space
    That of `PushTEnv` with arrays (N, 2).

    ## Rewards
    (N,), float64.

    ## Starting state
    `reset(seed=s)` seeds sub-environment i with s + i; a list gives one seed (or None) for each.
    The options are those of `PushTEnv`, for all. Alternatively `per_env`: a list of N dictionaries
    of options. In addition `reset_mask`: a boolean array (N,) of those to reset, at least one.

    ## Episode end
    An episode ends like the single environment's, or is truncated after `max_episode_steps`. With
    `AutoresetMode.NEXT_STEP` the next step starts a new episode instead of moving (its action is
    ignored, its reward is 0). With `AutoresetMode.DISABLED` the sub-environment freezes: it is not
    stepped, its reward is 0 and its flags stay, until it is reset.

    ## Arguments
    `num_envs`, `max_episode_steps`, `autoreset_mode` (a member of `AutoresetMode` or its value),
    those of `PushTEnv`, and `wrappers`: each is called with a single environment, the first one
    innermost. (`gymnasium.make_vec` keeps its argument of that name to itself: build this class for
    wrapped environments.)

    ## Info
    Arrays (N, ...) with a mask `_key` each, after Gymnasium's convention: the single environment's,
    and, under the names that this package's environments share, `position` (N, 2), the pusher's,
    px; `distance` (N,), the pose error, px; and `collision` (N,), always False: nothing here ends
    an episode but success.

    Example:
        >>> from functools import partial
        >>> from aicon_envs.pusht import PushTVectorEnv
        >>> from aicon_envs.pusht.wrappers import Delay, SensorNoise
        >>> wrappers = [partial(SensorNoise, sigma=2.0), partial(Delay, steps=3)]
        >>> env = PushTVectorEnv(num_envs=2, wrappers=wrappers)
        >>> observation, info = env.reset(seed=0)
        >>> observation["environment_state"].shape, info["distance"].shape
        ((2, 16), (2,))
    """

    def __init__(
        self,
        num_envs: int = 1,
        max_episode_steps: int = 300,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        wrappers: Sequence[Wrapper] = (),
        **arguments: Any,
    ) -> None:
        """Create the environments; see the class for the arguments.

        Raises:
            ValueError: If a value is not valid; the message names it and says what is.
            TypeError: If a keyword is unknown.
        """
        self.num_envs = check_count("num_envs", num_envs)
        self.max_episode_steps = check_count("max_episode_steps", max_episode_steps)
        self.autoreset_mode = check_autoreset_mode(autoreset_mode)
        self.metadata = PushTEnv.metadata | {"autoreset_mode": self.autoreset_mode}

        self._unwrapped_envs = [PushTEnv(**arguments) for _ in range(num_envs)]
        self.envs = [_wrap(env, wrappers) for env in self._unwrapped_envs]
        self.render_mode = self._unwrapped_envs[0].render_mode

        self.single_observation_space = self.envs[0].observation_space
        self.single_action_space = self.envs[0].action_space
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)

        # The last result of each sub-environment.
        self._observations: list[Observation] = [None] * num_envs
        self._info_of_each: list[dict[str, Any]] = [{}] * num_envs
        self._steps = np.zeros(num_envs, dtype=np.int64)
        self._terminated: BoolArray = np.zeros(num_envs, dtype=np.bool_)
        self._truncated: BoolArray = np.zeros(num_envs, dtype=np.bool_)

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Observation, dict[str, Any]]:
        """Start episodes; see the class for seeds and options."""
        options = copy_options(options)
        mask = check_reset_mask(options.pop("reset_mask", None), self.num_envs)
        options_of_each = split_options(options, self.num_envs)
        seeds = split_seed(seed, self.num_envs)

        for index in np.flatnonzero(mask).tolist():
            self._start_episode(index, seeds[index], options_of_each[index])

        return self._batch_observations(), self._batch_infos(mask)

    def step(
        self, actions: Action
    ) -> tuple[Observation, NDArray[np.float64], BoolArray, BoolArray, dict[str, Any]]:
        """Move every sub-environment by one step, or start its next episode; see the class."""
        self._check_started()
        commands = check_action(actions, (self.num_envs, 2), MEANING)

        # Those whose episode has ended do not move, and have no reward.
        ended = self._terminated | self._truncated
        reward = np.zeros(self.num_envs)
        for index in np.flatnonzero(~ended).tolist():
            reward[index] = self._step_one(index, commands[index])

        self._steps += ~ended
        self._truncated = self._steps >= self.max_episode_steps

        if self.autoreset_mode is AutoresetMode.NEXT_STEP:
            for index in np.flatnonzero(ended).tolist():
                self._start_episode(index, None, {})

        return (
            self._batch_observations(),
            reward,
            self._terminated.copy(),
            self._truncated.copy(),
            self._batch_infos(np.ones(self.num_envs, dtype=np.bool_)),
        )

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """Return a picture of each world, (height, width, 3), if there is a `render_mode`."""
        if self.render_mode is None:
            return None

        self._check_started()
        pictures = [env.render() for env in self._unwrapped_envs]
        return tuple(picture for picture in pictures if picture is not None)

    def _check_started(self) -> None:
        if not all(self._info_of_each):
            raise ResetNeeded("every sub-environment must be reset first")

    def _start_episode(self, index: int, seed: int | None, options: dict[str, Any]) -> None:
        observation, info = self.envs[index].reset(seed=seed, options=options)
        self._observations[index] = observation
        self._info_of_each[index] = info

        self._steps[index] = 0
        self._terminated[index] = False
        self._truncated[index] = False

    def _step_one(self, index: int, command: NDArray[np.float64]) -> float:
        """Move one sub-environment; return its reward."""
        observation, reward, terminated, _, info = self.envs[index].step(command)
        self._observations[index] = observation
        self._terminated[index] = terminated
        self._info_of_each[index] = info
        return float(reward)

    def _batch_observations(self) -> Observation:
        # A new array each time: what was returned before stays as it is.
        empty: Any = create_empty_array(self.single_observation_space, self.num_envs)
        return concatenate(self.single_observation_space, self._observations, empty)

    def _batch_infos(self, mask: BoolArray) -> dict[str, Any]:
        infos: dict[str, Any] = {}
        for key in _INFO_KEYS:
            infos[key] = np.array([info[key] for info in self._info_of_each])

        # The names that this package's environments share.
        infos["position"] = infos["pos_agent"].copy()
        infos["distance"] = infos["pose_error"].copy()
        infos["collision"] = np.zeros(self.num_envs, dtype=np.bool_)

        return infos | {f"_{key}": mask.copy() for key in infos}


def _wrap(env: gym.Env[Any, Any], wrappers: Sequence[Wrapper]) -> gym.Env[Any, Any]:
    for wrapper in wrappers:
        env = wrapper(env)

    return env
