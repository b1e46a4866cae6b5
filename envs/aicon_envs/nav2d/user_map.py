"""A map of the user's own, checked before it becomes a world."""

from typing import Any

import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray

from aicon_envs.checks import check_numbers, check_vertices, is_sequence
from aicon_envs.nav2d.world import NavigationMap, Point, Vertices, to_polygons

USER_MAP_KEYS = ("obstacles", "start", "target")
"""Options of a reset that describe a map of the user's own."""

_A_POINT = "two finite coordinates (x, y) in metres"


def make_user_map(
    obstacles: Any, start: ArrayLike, target: ArrayLike, radius: float
) -> NavigationMap:
    """Check a user's own map.

    Args:
        obstacles: Polygons, each a list of at least three vertices (x, y), m.
        start: Start (x, y), m; farther than `radius` from every obstacle.
        target: Target (x, y), m; in none of them.
        radius: Radius of the agent, m.

    Raises:
        ValueError: If an argument has another shape, is not finite, or does not describe a valid
            map.
    """
    if not is_sequence(obstacles):
        raise ValueError(f"obstacles must be a list of polygons, got {type(obstacles).__name__}")

    polygons = []
    for index, vertices in enumerate(obstacles):
        polygon = check_vertices(f"obstacles[{index}]", vertices, "metres")
        polygons.append([(x, y) for x, y in polygon.tolist()])

    world = NavigationMap(
        "user", polygons, _check_point("start", start), _check_point("target", target)
    )
    _check_places(world, _check_areas(polygons), radius)
    return world


def _check_places(world: NavigationMap, solid: NDArray[np.object_], radius: float) -> None:
    """Check that an episode can begin at the start, and end at the target."""
    # An agent that touches an obstacle at the start would collide at once.
    if (shapely.distance(solid, shapely.Point(world.start)) <= radius).any():
        raise ValueError(
            f"start must be farther than the radius {radius} m from every obstacle, "
            f"got {world.start}"
        )

    inside = np.flatnonzero(shapely.intersects(solid, shapely.Point(world.target)))
    if len(inside):
        raise ValueError(
            f"target must be outside of every obstacle, got {world.target}, "
            f"which is in obstacles[{inside[0]}]"
        )


def _check_point(name: str, value: ArrayLike) -> Point:
    x, y = check_numbers(name, value, _A_POINT, 2)
    return x, y


def _check_areas(polygons: list[Vertices]) -> NDArray[np.object_]:
    """Return the polygons of shapely, (n,), each of which has an area without crossings."""
    solid = to_polygons(polygons)

    crossed = ~shapely.is_valid(solid)
    refused = np.flatnonzero(crossed | (shapely.area(solid) == 0.0))
    if len(refused):
        index = int(refused[0])
        reason = shapely.is_valid_reason(solid[index]) if crossed[index] else "no area"
        raise ValueError(f"obstacles[{index}] must be a simple polygon with an area: {reason}")
    return solid
