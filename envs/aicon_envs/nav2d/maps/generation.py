"""From the name of a class of maps to a map: draw layouts until one passes the checks."""

import numpy as np

from aicon_envs.checks import check_choice
from aicon_envs.nav2d.maps.checks import is_valid
from aicon_envs.nav2d.maps.clutter import clutter, random_unions
from aicon_envs.nav2d.maps.enclosures import (
    bug_trap,
    ring_inside,
    ring_outside,
    spiral_in,
    spiral_out,
)
from aicon_envs.nav2d.maps.layout import LayoutGenerator, draw_orientation
from aicon_envs.nav2d.maps.mazes import corridors, maze
from aicon_envs.nav2d.maps.walls import l_shape, long_wall, u_trap, zigzag
from aicon_envs.nav2d.world import NavigationMap, to_vertices

_GENERATORS: dict[str, LayoutGenerator] = {
    "u_trap_05": u_trap(0.5),
    "u_trap_1": u_trap(1.0),
    "u_trap_2": u_trap(2.0),
    "u_trap_4": u_trap(4.0),
    "l_shape": l_shape,
    "zigzag": zigzag,
    "long_wall": long_wall,
    "ring_outside": ring_outside,
    "ring_inside": ring_inside,
    "clutter": clutter,
    "random_unions": random_unions,
    "corridors": corridors,
    "bug_trap": bug_trap,
    "spiral_in": spiral_in,
    "spiral_out": spiral_out,
    "maze": maze,
}
_ALIASES = {"u_trap": "u_trap_2"}
_MIXED = "mixed"
_MAX_ATTEMPTS = 200

MAP_NAMES: tuple[str, ...] = tuple(_GENERATORS)
"""Names of the classes of maps; "mixed" draws one of them, "u_trap" is another for "u_trap_2"."""


def check_map_name(name: str) -> str:
    """Return the name.

    Raises:
        ValueError: If no class of maps has this name; the message lists the valid ones.
    """
    check_choice("map", name, (*MAP_NAMES, *_ALIASES, _MIXED))
    return name


def make_map(name: str, rng: np.random.Generator) -> NavigationMap:
    """Generate a map.

    Start and target are at least 0.4 m from every obstacle and connected by a way at least 0.5 m
    wide; the straight way between them is blocked. A map of the class "mixed" is the one that its
    class, drawn from a child of `rng`, generates from `rng` itself.

    Args:
        name: One of `MAP_NAMES`, "u_trap" or "mixed".
        rng: Source of all randomness; the same state gives the same map.

    Raises:
        ValueError: If the name is unknown.
        RuntimeError: If no valid map was found in 200 attempts.
    """
    name = _ALIASES.get(check_map_name(name), name)
    if name == _MIXED:
        # From a child of `rng`, whose own stream stays untouched.
        (child,) = rng.spawn(1)
        name = MAP_NAMES[int(child.integers(len(MAP_NAMES)))]

    # Rejection sampling: the next attempt goes on with the same stream.
    for _ in range(_MAX_ATTEMPTS):
        layout = _GENERATORS[name](rng)
        layout = draw_orientation(layout, rng)

        if is_valid(name, layout):
            return NavigationMap(name, to_vertices(layout.solid), layout.start, layout.target)

    raise RuntimeError(f"no valid map of class {name} in {_MAX_ATTEMPTS} attempts")
