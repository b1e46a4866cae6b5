"""The evaluation task "nav2d": 15 classes of traps and, twice as often, mazes."""

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv

from aicon_baselines.ablations import NAV2D
from aicon_baselines.evaluation.task import Episode, Look, Task
from aicon_baselines.tasks.faults import FAULTS, Faults, are_faults, longest
from aicon_envs.nav2d import Physics, make_map, shortest_path_length

_SLOTS = (
    "u_trap_05",
    "ring_outside",
    "zigzag",
    "clutter",
    "u_trap_1",
    "spiral_in",
    "long_wall",
    "corridors",
    "maze",
    "u_trap_2",
    "ring_inside",
    "l_shape",
    "random_unions",
    "u_trap_4",
    "bug_trap",
    "spiral_out",
    "maze",
)


_FAULTS = Faults(
    dt=Physics().dt,
    late=4,
    jitter=8,
    onset=(40, 200),
    pause=100,
    bias={"range": 0.05},
    ranges={"range": (0.0, Physics().max_range), "bearing": (-math.pi, math.pi)},
    held=10,
    told={"range_offset": 0.05},
    tells_action=True,
)


def _make_env(count: int, condition: str, horizon: int, **options: Any) -> VectorEnv[Any, Any, Any]:
    """Build the environment; a policy may ask for another `sensing` than that of the condition."""
    if are_faults(condition):
        env = _make_env(count, "range", longest(condition, horizon), **options)
        return _FAULTS.wrap(env, condition)

    return gymnasium.make_vec(
        "aicon/Nav2D-v0",
        num_envs=count,
        vectorization_mode="vector_entry_point",
        autoreset_mode=AutoresetMode.DISABLED,
        max_episode_steps=horizon,
        **{"sensing": condition, **options},
    )


def _reset_arguments(episodes: Sequence[Episode]) -> dict[str, Any]:
    noise_seeds = [episode.noise_seed for episode in episodes]
    maps = [episode.map for episode in episodes]
    map_seeds = [episode.seed for episode in episodes]
    return {"seed": noise_seeds, "options": {"map": maps, "map_seed": map_seeds}}


def _policy_options(condition: str) -> dict[str, Any]:
    """Tell the policy what its sensors are, and how late."""
    if are_faults(condition):
        return {"sensing": "range", **_FAULTS.policy_options(condition)}
    return {"sensing": condition}


def _shortest_path_length(episode: Episode) -> float:
    return _shortest_path_length_of_map(episode.map, episode.seed)


@lru_cache(maxsize=1024)  # a map is asked for once per policy, condition and repeat
def _shortest_path_length_of_map(name: str, seed: int) -> float:
    _, obstacles, start, target = make_map(name, np.random.default_rng(seed))
    return shortest_path_length(obstacles, start, target, Physics().radius)


TASK = Task(
    name="nav2d",
    time_step=Physics().dt,
    horizon=12_000,
    chunk_size=128,
    maps=_SLOTS,
    conditions=("range", "range_bearing", *FAULTS),
    faults=FAULTS,
    make_env=_make_env,
    reset_arguments=_reset_arguments,
    policy_options=_policy_options,
    shortest_path_length=_shortest_path_length,
    model="nav2d",
    presets=("aicon", "paper_literal", "steepest", "potential_field"),
    ablations=NAV2D,
    agents={
        "bug2": "aicon_baselines.agents.nav2d:Bug2",
        "wall_follower": "aicon_baselines.agents.nav2d:WallFollower",
    },
    look=Look(
        scene="aicon_baselines.view.nav2d:NavigationScene",
        surroundings="aicon_baselines.worlds.surroundings:around_navigation",
    ),
)
