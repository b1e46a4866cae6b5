"""The page about navigation: the project's maps, and what the policy runs in them with."""

import dataclasses
from typing import Any

import numpy as np

from aicon_envs.nav2d import MAP_NAMES, Physics, make_map
from aicon_envs.nav2d.simulation import ARRIVAL_DISTANCE
from building.packing import pack
from building.variants import variants

MAP_SEEDS = range(1000, 1003)
"""Seeds of the maps, one of each class for each."""


def data() -> dict[str, Any]:
    """What the page holds."""
    return {
        "policies": {name: pack(policy) for name, policy in variants("nav2d")},
        "maps": [map_of(name, seed) for seed in MAP_SEEDS for name in MAP_NAMES],
        "physics": physics(),
    }


def map_of(name: str, seed: int) -> dict[str, Any]:
    """A map, to the millimetre."""
    world = make_map(name, np.random.default_rng(seed))
    obstacles = [np.round(corners, 3).tolist() for corners in world.obstacles]
    start, target = np.round(world.start, 3).tolist(), np.round(world.target, 3).tolist()
    return {"name": world.name, "obstacles": obstacles, "start": start, "target": target}


def physics() -> dict[str, float]:
    """The constants of the agent and its sensors."""
    return {**dataclasses.asdict(Physics()), "arrival": ARRIVAL_DISTANCE}
