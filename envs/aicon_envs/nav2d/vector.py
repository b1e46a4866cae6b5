"""The navigation task as a native Gymnasium vector environment."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.error import ResetNeeded
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from aicon_envs.nav2d.environment import Nav2DEnv, check_render_mode, draw_episode
from aicon_envs.nav2d.maps import check_map_name
from aicon_envs.nav2d.options import split_options
from aicon_envs.nav2d.physics import Physics
from aicon_envs.nav2d.rendering import Scene
from aicon_envs.nav2d.simulation import Simulation
from aicon_envs.nav2d.spaces import Action, Observation, Sensing, action_space, check_action, observation_space
from aicon_envs.nav2d.world import NavigationMap

BoolArray = NDArray[np.bool_]


class Nav2DVectorEnv(VectorEnv[Observation, Action, NDArray[Any]]):
    """N copies of `Nav2DEnv`, stepped as one batch; each gives the same trajectory as a single one would.

    Observations are float32 arrays (N, 1), rewards (N,) float64. Infos are arrays (N, ...) with a mask `_key` each,
    after Gymnasium's convention; `map` and `map_seed` are present for those just reset.

    ## Seeds
    `reset(seed=s)` seeds sub-environment i with s + i; a list gives one seed (or None) for each.

    ## Options
    Those of `Nav2DEnv`, for all; the values of `map` and `map_seed` may be lists of length N. Alternatively `per_env`:
    a list of N dictionaries of options. In addition `reset_mask`: a boolean array (N,) of those to reset, at least one.

    ## Ends of episodes
    An episode ends like the single environment's, or is truncated after `max_episode_steps`. With
    `AutoresetMode.NEXT_STEP` the next step starts a new episode instead of moving (its action is ignored, its reward
    is 0). With `AutoresetMode.DISABLED` the sub-environment freezes: it no longer moves, its reward is 0 and its flags
    stay, until it is reset.

    ## Arguments
    `num_envs`, `max_episode_steps`, `autoreset_mode` (a member of `AutoresetMode` or its value), and those of
    `Nav2DEnv`.
    """

    def __init__(
        self,
        num_envs: int = 1,
        max_episode_steps: int = 12_000,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        map: str = "mixed",
        sensing: Sensing = "range",
        render_mode: str | None = None,
        **physics: float,
    ) -> None:
        """Create the environments; see the class for the arguments.

        Raises:
            ValueError: If a value is not valid; the message names it and lists what is.
            TypeError: If a keyword is unknown.
        """
        for name, value in (("num_envs", num_envs), ("max_episode_steps", max_episode_steps)):
            if value < 1:
                raise ValueError(f"{name} must be >= 1, got {value}")
        self.num_envs = num_envs
        self.max_episode_steps = max_episode_steps
        self.autoreset_mode = _check_autoreset_mode(autoreset_mode)
        self.metadata = Nav2DEnv.metadata | {"autoreset_mode": self.autoreset_mode}
        self.physics = Physics.from_options(physics)
        observations, actions = observation_space(sensing, self.physics), action_space(self.physics)
        self.single_observation_space, self.observation_space = observations, batch_space(observations, num_envs)
        self.single_action_space, self.action_space = actions, batch_space(actions, num_envs)
        self.render_mode = check_render_mode(render_mode)
        self._default_map = check_map_name(map)
        self._with_obstacle_bearing = sensing == "range_bearing"
        self._simulation = Simulation(num_envs, self.physics)
        self._generators = [seeding.np_random()[0] for _ in range(num_envs)]
        self._maps: dict[int, NavigationMap] = {}
        self._scenes: dict[int, Scene] = {}
        self._steps = np.zeros(num_envs, dtype=np.int64)
        self._truncated: BoolArray = np.zeros(num_envs, dtype=np.bool_)

    @property
    def maps(self) -> list[NavigationMap]:
        """The map of each sub-environment's current episode."""
        return [self._maps[index] for index in range(self.num_envs)]

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Start episodes; see the class for seeds and options."""
        options = dict(options or {})
        mask = _check_mask(options.pop("reset_mask", None), self.num_envs)
        each = split_options(options, self.num_envs)
        seeds = _split_seed(seed, self.num_envs)
        for index in np.flatnonzero(mask):
            if seeds[index] is not None:
                self._generators[index], _ = seeding.np_random(seeds[index])
        origins = self._start_episodes(np.flatnonzero(mask).tolist(), each)
        return self._observe(), self._infos(mask, origins)

    def step(self, actions: Action) -> tuple[Observation, NDArray[np.float64], BoolArray, BoolArray, dict[str, Any]]:
        """Move every sub-environment by one step, or start its next episode; see the class."""
        if len(self._maps) < self.num_envs:
            raise ResetNeeded("every sub-environment must be reset before the first step")
        simulation = self._simulation
        ended = simulation.ended | self._truncated
        simulation.step(check_action(actions, (self.num_envs, 2)))
        self._steps += ~ended
        self._truncated = self._steps >= self.max_episode_steps
        simulation.active &= ~self._truncated
        origins: dict[int, dict[str, Any]] = {}
        if self.autoreset_mode is AutoresetMode.NEXT_STEP and ended.any():
            origins = self._start_episodes(np.flatnonzero(ended).tolist(), [{}] * self.num_envs)
        for index, scene in self._scenes.items():
            scene.move(simulation.position[:, index])
        infos = self._infos(np.ones(self.num_envs, dtype=np.bool_), origins)
        return self._observe(), simulation.reward.copy(), simulation.ended.copy(), self._truncated.copy(), infos

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """Return a picture of each world, (height, width, 3), if `render_mode` is "rgb_array"."""
        if self.render_mode is None:
            return None
        return tuple(self._scenes[index].draw() for index in range(self.num_envs))

    def _start_episodes(self, indices: list[int], options: list[dict[str, Any]]) -> dict[int, dict[str, Any]]:
        """Load a new map into each of the sub-environments `indices`; return what `info` tells about the maps."""
        default, radius = self._default_map, self.physics.radius
        drawn = [draw_episode(self._generators[index], options[index], default, radius) for index in indices]
        worlds, noises, origins = zip(*drawn, strict=True)
        self._simulation.load(indices, worlds, noises)
        self._steps[indices] = 0
        self._truncated[indices] = False
        self._maps |= zip(indices, worlds, strict=True)
        if self.render_mode is not None:
            self._scenes |= {index: Scene(self._maps[index], self.physics.radius) for index in indices}
        return dict(zip(indices, origins, strict=True))

    def _observe(self) -> Observation:
        simulation = self._simulation
        observation = {"bearing": simulation.sense_bearing(), "range": simulation.sense_range()}
        if self._with_obstacle_bearing:
            observation["obstacle_bearing"] = simulation.sense_obstacle_bearing()
        return {key: reading[:, np.newaxis] for key, reading in observation.items()}

    def _infos(self, mask: BoolArray, origins: dict[int, dict[str, Any]]) -> dict[str, Any]:
        simulation = self._simulation
        infos: dict[str, Any] = {
            "is_success": simulation.success.copy(),
            "collision": simulation.collision.copy(),
            "position": simulation.position.T.copy(),
            "target": simulation.target.T.copy(),
            "distance": simulation.distance.copy(),
            "clearance": simulation.clearance.copy(),
        }
        infos |= {f"_{key}": mask.copy() for key in infos}
        for index, origin in origins.items():
            infos = self._add_info(infos, origin, index)
        return infos


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
