"""How an episode starts: what `reset` draws and what its options ask for."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from aicon_envs.checks import check_integer, given_options
from aicon_envs.nav2d.maps import make_map
from aicon_envs.nav2d.user_map import USER_MAP_KEYS, make_user_map
from aicon_envs.nav2d.world import NavigationMap

GENERATED_MAP_KEYS = ("map", "map_seed")
"""Options of a reset that ask for a generated map."""

_OPTION_KEYS = (*GENERATED_MAP_KEYS, *USER_MAP_KEYS)


class EpisodeStart(NamedTuple):
    """What is fixed at a reset.

    Attributes:
        map: The world of the episode.
        noise: Source of all noise of the episode.
        info: What `info` tells about the map: `map`, and `map_seed` if it was generated.
    """

    map: NavigationMap
    noise: np.random.Generator
    info: dict[str, Any]


def draw_episode(
    generator: np.random.Generator,
    options: Mapping[str, Any] | None,
    default_map: str,
    radius: float,
) -> EpisodeStart:
    """Draw what an episode needs.

    Takes two numbers from an environment's stream, whatever the options.

    Args:
        generator: The environment's `np_random`.
        options: See :func:`resolve_map`.
        default_map: Name of the class of maps used without the option `map`.
        radius: Radius of the agent, m.

    Raises:
        ValueError: If an option is unknown or its value not usable; the message names it.
    """
    map_seed, noise_seed = generator.integers(2**63, size=2).tolist()
    world, info = resolve_map(options, default_map, map_seed, radius)
    return EpisodeStart(world, np.random.default_rng(noise_seed), info)


def resolve_map(
    options: Mapping[str, Any] | None, default_map: str, default_seed: int, radius: float
) -> tuple[NavigationMap, dict[str, Any]]:
    """Build the map that the options of one reset ask for.

    Args:
        options: Either `map` and `map_seed` (both optional), or all of `obstacles`, `start` and
            `target`.
        default_map: Name used without `map`.
        default_seed: Seed used without `map_seed`.
        radius: Radius of the agent, m; the start must be farther than this from every obstacle.

    Returns:
        The map, and what `info` tells about it: `map`, and `map_seed` if it was generated.

    Raises:
        ValueError: If a key is unknown or a value is not usable; the message names it.
    """
    options = given_options(options, _OPTION_KEYS)

    if any(key in options for key in USER_MAP_KEYS):
        return _resolve_user_map(options, radius), {"map": "user"}

    # A seed of its own for the map: it can be generated again without the rest of the episode.
    seed = check_integer("map_seed", options.get("map_seed", default_seed), 0)
    world = make_map(options.get("map", default_map), np.random.default_rng(seed))
    return world, {"map": world.name, "map_seed": seed}


def _resolve_user_map(options: Mapping[str, Any], radius: float) -> NavigationMap:
    """Build a map of the user's own, which needs all of its options and no others."""
    valid = ", ".join(USER_MAP_KEYS)

    missing = [key for key in USER_MAP_KEYS if key not in options]
    if missing:
        raise ValueError(f"a map of your own needs {valid}; missing: {', '.join(missing)}")

    contradicting = [key for key in GENERATED_MAP_KEYS if key in options]
    if contradicting:
        raise ValueError(f"{', '.join(contradicting)} cannot be combined with {valid}")

    return make_user_map(options["obstacles"], options["start"], options["target"], radius)
