"""Many pushT environments in one process."""

from collections.abc import Callable, Sequence
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.error import ResetNeeded
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space, concatenate, create_empty_array
from numpy.typing import ArrayLike, NDArray

from aicon_envs.pusht.environment import PushTEnv
from aicon_envs.pusht.spaces import Action, Observation

BoolArray = NDArray[np.bool_]
Wrapper = Callable[[gym.Env[Any, Any]], gym.Env[Any, Any]]

_INFOS = ("is_success", "coverage", "block_pose", "goal_pose", "pos_agent", "vel_agent", "n_contacts", "pose_error")


class PushTVectorEnv(VectorEnv[Observation, Action, NDArray[Any]]):
    """N copies of `PushTEnv`, stepped one after the other; each gives the same trajectory as a single one would.

    Observations are arrays (N, ...) or dictionaries of them, rewards (N,) float64.

    ## Seeds
    `reset(seed=s)` seeds sub-environment i with s + i; a list gives one seed (or None) for each.

    ## Options
    Those of `PushTEnv`, for all. Alternatively `per_env`: a list of N dictionaries of options. In addition
    `reset_mask`: a boolean array (N,) of those to reset, at least one.

    ## Ends of episodes
    An episode ends like the single environment's, or is truncated after `max_episode_steps`. With
    `AutoresetMode.NEXT_STEP` the next step starts a new episode instead of moving (its action is ignored, its reward
    is 0). With `AutoresetMode.DISABLED` the sub-environment freezes: it is not stepped, its reward is 0 and its flags
    stay, until it is reset.

    ## Info
    Arrays (N, ...) with a mask `_key` each, after Gymnasium's convention: the single environment's, and, under the
    names that this package's environments share, `position` (N, 2), the pusher's, px; `distance` (N,), the pose error,
    px; and `collision` (N,), always False: nothing here ends an episode but success.

    ## Arguments
    `num_envs`, `max_episode_steps`, `autoreset_mode` (a member of `AutoresetMode` or its value), those of `PushTEnv`,
    and `wrappers`: each is called with a single environment, the first one innermost. (`gymnasium.make_vec` keeps its
    argument of that name to itself: build this class for wrapped environments.)

    Example:
        >>> from functools import partial
        >>> from aicon_envs.pusht import PushTVectorEnv
        >>> from aicon_envs.pusht.wrappers import Delay, SensorNoise
        >>> env = PushTVectorEnv(num_envs=2, wrappers=[partial(SensorNoise, sigma=2.0), partial(Delay, steps=3)])
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
        for name, value in (("num_envs", num_envs), ("max_episode_steps", max_episode_steps)):
            if value < 1:
                raise ValueError(f"{name} must be >= 1, got {value}")
        self.num_envs = num_envs
        self.max_episode_steps = max_episode_steps
        self.autoreset_mode = _check_autoreset_mode(autoreset_mode)
        self.metadata = PushTEnv.metadata | {"autoreset_mode": self.autoreset_mode}
        self._plain = [PushTEnv(**arguments) for _ in range(num_envs)]
        self.envs = [_wrapped(env, wrappers) for env in self._plain]
        observations, actions = self.envs[0].observation_space, self.envs[0].action_space
        self.single_observation_space, self.observation_space = observations, batch_space(observations, num_envs)
        self.single_action_space, self.action_space = actions, batch_space(actions, num_envs)
        self.render_mode = self._plain[0].render_mode
        self._observations: list[Observation] = [None] * num_envs
        self._each_info: list[dict[str, Any]] = [{}] * num_envs
        self._steps = np.zeros(num_envs, dtype=np.int64)
        self._terminated: BoolArray = np.zeros(num_envs, dtype=np.bool_)
        self._truncated: BoolArray = np.zeros(num_envs, dtype=np.bool_)

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Start episodes; see the class for seeds and options."""
        options = dict(options or {})
        mask = _check_mask(options.pop("reset_mask", None), self.num_envs)
        each = _split_options(options, self.num_envs)
        seeds = _split_seed(seed, self.num_envs)
        for index in np.flatnonzero(mask).tolist():
            self._start_episode(index, seeds[index], each[index])
        return self._batch(), self._infos(mask)

    def step(self, actions: Action) -> tuple[Observation, NDArray[np.float64], BoolArray, BoolArray, dict[str, Any]]:
        """Move every sub-environment by one step, or start its next episode; see the class."""
        if not all(self._each_info):
            raise ResetNeeded("every sub-environment must be reset before the first step")
        commands = _check_actions(actions, self.num_envs)
        ended = self._terminated | self._truncated
        reward = np.zeros(self.num_envs)
        for index in np.flatnonzero(~ended).tolist():
            result = self.envs[index].step(commands[index])
            self._observations[index], reward[index], self._terminated[index], _, self._each_info[index] = result
        self._steps += ~ended
        self._truncated = self._steps >= self.max_episode_steps
        if self.autoreset_mode is AutoresetMode.NEXT_STEP:
            for index in np.flatnonzero(ended).tolist():
                self._start_episode(index, None, {})
        infos = self._infos(np.ones(self.num_envs, dtype=np.bool_))
        return self._batch(), reward, self._terminated.copy(), self._truncated.copy(), infos

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """Return a picture of each world, (height, width, 3), if `render_mode` is "rgb_array"."""
        pictures = [env.render() for env in self._plain]
        return None if self.render_mode is None else tuple(each for each in pictures if each is not None)

    def _start_episode(self, index: int, seed: int | None, options: dict[str, Any]) -> None:
        self._observations[index], self._each_info[index] = self.envs[index].reset(seed=seed, options=options)
        self._steps[index] = 0
        self._terminated[index] = self._truncated[index] = False

    def _batch(self) -> Observation:
        empty: Any = create_empty_array(self.single_observation_space, self.num_envs)
        return concatenate(self.single_observation_space, self._observations, empty)

    def _infos(self, mask: BoolArray) -> dict[str, Any]:
        infos = {key: np.array([info[key] for info in self._each_info]) for key in _INFOS}
        infos |= {
            "position": infos["pos_agent"].copy(),
            "distance": infos["pose_error"].copy(),
            "collision": np.zeros(self.num_envs, dtype=np.bool_),
        }
        return infos | {f"_{key}": mask.copy() for key in infos}


def _wrapped(env: gym.Env[Any, Any], wrappers: Sequence[Wrapper]) -> gym.Env[Any, Any]:
    for wrapper in wrappers:
        env = wrapper(env)
    return env


def _check_actions(actions: ArrayLike, num_envs: int) -> NDArray[np.float64]:
    commands = np.asarray(actions, dtype=np.float64)
    if commands.shape != (num_envs, 2):
        raise ValueError(f"action must be numbers (x, y) of shape {(num_envs, 2)}, got shape {commands.shape}")
    if not np.isfinite(commands).all():
        raise ValueError(f"action must be finite, got {commands.tolist()}")
    return commands


def _split_options(options: dict[str, Any], num_envs: int) -> list[dict[str, Any]]:
    if "per_env" not in options:
        return [options] * num_envs
    if len(options) > 1:
        raise ValueError(f"per_env excludes other options, got {', '.join(map(str, options))}")
    each = list(options["per_env"])
    if len(each) != num_envs:
        raise ValueError(f"per_env must have one entry for each of the {num_envs} sub-environments, got {len(each)}")
    return each


def _split_seed(seed: int | Sequence[int | None] | None, num_envs: int) -> list[int | None]:
    if seed is None:
        return [None] * num_envs
    if isinstance(seed, int):
        return [seed + index for index in range(num_envs)]
    if len(seed) != num_envs:
        raise ValueError(f"seed must be one integer or {num_envs} of them, got {len(seed)}")
    return list(seed)


def _check_mask(mask: Any, num_envs: int) -> BoolArray:
    if mask is None:
        return np.ones(num_envs, dtype=np.bool_)
    array = np.asarray(mask)
    if array.shape != (num_envs,) or array.dtype != np.bool_ or not array.any():
        raise ValueError(
            f"reset_mask must be a boolean array of shape ({num_envs},) with at least one True, got {mask!r}"
        )
    return array


def _check_autoreset_mode(mode: AutoresetMode | str) -> AutoresetMode:
    supported = (AutoresetMode.NEXT_STEP, AutoresetMode.DISABLED)
    for candidate in supported:
        if mode in (candidate, candidate.value):
            return candidate
    raise ValueError(f"autoreset_mode must be one of {', '.join(str(each) for each in supported)}, got {mode!r}")
