"""The navigation task as a native Gymnasium vector environment."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.error import ResetNeeded
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from aicon_envs.arrays import BoolArray, FloatArray
from aicon_envs.checks import (
    check_action,
    check_integer,
    check_render_mode,
    copy_options,
    fields_of,
)
from aicon_envs.nav2d.batching import (
    check_autoreset_mode,
    check_reset_mask,
    split_options,
    split_seed,
)
from aicon_envs.nav2d.maps import check_map_name
from aicon_envs.nav2d.physics import Physics
from aicon_envs.nav2d.rendering import Scene
from aicon_envs.nav2d.reset import GENERATED_MAP_KEYS, draw_episode
from aicon_envs.nav2d.simulation import Simulation
from aicon_envs.nav2d.spaces import (
    VELOCITY,
    Action,
    Observation,
    Sensing,
    action_space,
    observation_space,
)
from aicon_envs.nav2d.world import NavigationMap

RENDERING = {"render_modes": ["rgb_array"], "render_fps": 20}
"""What Gymnasium's metadata say of pictures."""


class Nav2DVectorEnv(VectorEnv[Observation, Action, NDArray[Any]]):
    """N copies of `Nav2DEnv`, stepped as one batch; each moves as a single one would.

    ## Description
    The physics of all N worlds are a few numpy operations on arrays of N columns. Each world's
    trajectory is, number for number, that of a single environment with the same seed and actions.

    ## Observation space
    That of `Nav2DEnv` with arrays (N, 1), float32.

    ## Action space
    That of `Nav2DEnv` with arrays (N, 2).

    ## Rewards
    (N,), float64.

    ## Starting state
    `reset(seed=s)` seeds sub-environment i with s + i; a list gives one seed (or None) for each.
    The options are those of `Nav2DEnv`, for all; the values of `map` and `map_seed` may be lists of
    length N. Alternatively `per_env`: a list of N dictionaries of options. In addition
    `reset_mask`: a boolean array (N,) of those to reset, at least one.

    ## Episode end
    An episode ends like the single environment's, or is truncated after `max_episode_steps`. With
    `AutoresetMode.NEXT_STEP` the next step starts a new episode instead of moving (its action is
    ignored, its reward is 0). With `AutoresetMode.DISABLED` the sub-environment freezes: it no
    longer moves, its reward is 0 and its flags stay, until it is reset.

    ## Arguments
    `num_envs`, `max_episode_steps`, `autoreset_mode` (a member of `AutoresetMode` or its value),
    and those of `Nav2DEnv`.

    ## Info
    Arrays (N, ...) with a mask `_key` each, after Gymnasium's convention; `map` and `map_seed` are
    present for those just reset.

    Attributes:
        generators: The random numbers of each environment, from which its episodes are drawn.
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
        self.num_envs = check_integer("num_envs", num_envs, 1)
        self.max_episode_steps = check_integer("max_episode_steps", max_episode_steps, 1)
        self.autoreset_mode = check_autoreset_mode(autoreset_mode)
        self.metadata = RENDERING | {"autoreset_mode": self.autoreset_mode}
        self.physics = fields_of(Physics, physics, type(self))

        self.single_observation_space = observation_space(sensing, self.physics)
        self.single_action_space = action_space(self.physics)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)

        self.render_mode = check_render_mode(render_mode)
        self._default_map = check_map_name(map)
        self._with_obstacle_bearing = sensing == "range_bearing"

        # A generator for each sub-environment, as a single environment has one.
        self._simulation = Simulation(num_envs, self.physics)
        self.generators = [seeding.np_random()[0] for _ in range(num_envs)]
        self._maps: dict[int, NavigationMap] = {}
        self._scenes: dict[int, Scene] = {}
        self._steps = np.zeros(num_envs, dtype=np.int64)
        self._truncated: BoolArray = np.zeros(num_envs, dtype=np.bool_)

    @property
    def maps(self) -> list[NavigationMap]:
        """The map of each sub-environment's current episode."""
        self._check_started()
        return [self._maps[index] for index in range(self.num_envs)]

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Observation, dict[str, Any]]:
        """Start episodes; see the class for seeds and options."""
        options = copy_options(options)
        mask = check_reset_mask(options.pop("reset_mask", None), self.num_envs)
        options_of_each = split_options(options, self.num_envs, listable=GENERATED_MAP_KEYS)
        seeds = split_seed(seed, self.num_envs)

        # Without a seed, a sub-environment goes on with its stream.
        indices: list[int] = np.flatnonzero(mask).tolist()
        for index in indices:
            if seeds[index] is not None:
                self.generators[index], _ = seeding.np_random(seeds[index])

        map_infos = self._start_episodes(indices, options_of_each)
        return self._observe(), self._infos(mask, map_infos)

    def step(
        self, actions: Action
    ) -> tuple[Observation, FloatArray, BoolArray, BoolArray, dict[str, Any]]:
        """Move every sub-environment by one step, or start its next episode; see the class."""
        self._check_started()
        simulation = self._simulation
        commands = check_action(actions, (self.num_envs, 2), VELOCITY)

        # Those whose episode has ended no longer move.
        ended = ~simulation.active
        simulation.step(commands)
        self._steps += ~ended
        self._truncated = self._steps >= self.max_episode_steps
        simulation.active &= ~self._truncated

        map_infos: dict[int, dict[str, Any]] = {}
        if self.autoreset_mode is AutoresetMode.NEXT_STEP and ended.any():
            indices: list[int] = np.flatnonzero(ended).tolist()
            map_infos = self._start_episodes(indices, [{}] * self.num_envs)

        for index, scene in self._scenes.items():
            scene.move(simulation.position[:, index])

        return (
            self._observe(),
            simulation.reward.copy(),
            simulation.ended.copy(),
            self._truncated.copy(),
            self._infos(np.ones(self.num_envs, dtype=np.bool_), map_infos),
        )

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """Return a picture of each world, (height, width, 3), if there is a `render_mode`."""
        if self.render_mode is None:
            return None

        self._check_started()
        return tuple(self._scenes[index].draw() for index in range(self.num_envs))

    def _check_started(self) -> None:
        if len(self._maps) < self.num_envs:
            raise ResetNeeded("every world must be reset first")

    def _start_episodes(
        self, indices: list[int], options_of_each: list[dict[str, Any]]
    ) -> dict[int, dict[str, Any]]:
        """Load a new map into the sub-environments `indices`; return what `info` tells of each."""
        radius = self.physics.radius

        episodes = {}
        for index in indices:
            episodes[index] = draw_episode(
                self.generators[index], options_of_each[index], self._default_map, radius
            )

        # One call for all of them: loading changes the arrays of all worlds.
        maps = [episode.map for episode in episodes.values()]
        noises = [episode.noise for episode in episodes.values()]
        self._simulation.load(indices, maps, noises)
        self._steps[indices] = 0
        self._truncated[indices] = False

        for index, world in zip(indices, maps, strict=True):
            self._maps[index] = world
            if self.render_mode is not None:
                self._scenes[index] = Scene(world, radius)

        return {index: episode.info for index, episode in episodes.items()}

    def _observe(self) -> Observation:
        simulation = self._simulation
        observation = {
            "bearing": simulation.sense_bearing()[:, np.newaxis],
            "range": simulation.sense_range()[:, np.newaxis],
        }

        if self._with_obstacle_bearing:
            bearing = simulation.sense_obstacle_bearing()
            observation["obstacle_bearing"] = bearing[:, np.newaxis]

        return observation

    def _infos(self, mask: BoolArray, map_infos: dict[int, dict[str, Any]]) -> dict[str, Any]:
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

        # The maps of those that were just reset, by Gymnasium's own convention.
        for index, map_info in map_infos.items():
            infos = self._add_info(infos, map_info, index)

        return infos
