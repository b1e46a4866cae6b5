"""What `reset(options=...)` accepts, and how it becomes a map."""

import operator
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import shapely
from numpy.typing import ArrayLike
from shapely.geometry import Polygon

from aicon_envs.nav2d.maps import make_map
from aicon_envs.nav2d.world import NavigationMap, Point, Vertices, union

_USER_KEYS = ("obstacles", "start", "target")
OPTION_KEYS = ("map", "map_seed", *_USER_KEYS)


def resolve_map(
    options: Mapping[str, Any] | None, default_map: str, default_seed: int, radius: float
) -> tuple[NavigationMap, dict[str, Any]]:
    """Build the map that the options of one reset ask for.

    Args:
        options: Either `map` and `map_seed` (both optional), or all of `obstacles`, `start` and `target`.
        default_map: Name used without `map`.
        default_seed: Seed used without `map_seed`.
        radius: Radius of the agent, m; the start must be farther than this from every obstacle.

    Returns:
        The map, and what `info` tells about it: `map`, and `map_seed` if it was generated.

    Raises:
        ValueError: If a key is unknown or a value is not usable; the message names it.
    """
    options = dict(options or {})
    unknown = sorted(map(str, set(options) - set(OPTION_KEYS)))
    if unknown:
        raise ValueError(f"unknown option {', '.join(unknown)}; valid options are {', '.join(OPTION_KEYS)}")
    given = [key for key in _USER_KEYS if key in options]
    if given:
        return _user_map(options, radius), {"map": "user"}
    seed = _natural_number("map_seed", options.get("map_seed", default_seed))
    generated = make_map(options.get("map", default_map), np.random.default_rng(seed))
    return generated, {"map": generated.name, "map_seed": seed}


def split_options(options: Mapping[str, Any] | None, num_envs: int) -> list[dict[str, Any]]:
    """Return the options of each sub-environment of a vector environment.

    Args:
        options: The options of one environment, for all; the values of `map` and `map_seed` may be sequences of length
            num_envs. Alternatively `per_env`: a sequence of num_envs dictionaries, the options of each.
        num_envs: Number of sub-environments.

    Raises:
        ValueError: If a sequence has another length, or `per_env` comes with other options.
    """
    options = dict(options or {})
    if "per_env" in options:
        if len(options) > 1:
            raise ValueError(f"per_env excludes other options, got {', '.join(map(str, options))}")
        return [dict(each) for each in _exactly(num_envs, "per_env", options["per_env"])]
    columns = {
        key: _exactly(num_envs, key, value)
        if key in ("map", "map_seed") and _is_sequence(value)
        else [value] * num_envs
        for key, value in options.items()
    }
    return [{key: column[index] for key, column in columns.items()} for index in range(num_envs)]


def parse_user_map(obstacles: Sequence[ArrayLike], start: ArrayLike, target: ArrayLike, radius: float) -> NavigationMap:
    """Check a user's own map.

    Args:
        obstacles: Polygons, each a list of at least three vertices (x, y), m.
        start: Start (x, y), m; farther than `radius` from every obstacle.
        target: Target (x, y), m.
        radius: Radius of the agent, m.

    Raises:
        ValueError: If an argument has another shape, is not finite, or does not describe a valid map.
    """
    polygons = [_polygon(index, vertices) for index, vertices in enumerate(obstacles)]
    world = NavigationMap("user", polygons, _point("start", start), _point("target", target))
    solid = union(polygons)
    if not solid.is_empty and solid.distance(shapely.Point(world.start)) <= radius:
        raise ValueError(f"start must be farther than the radius {radius} m from every obstacle, got {world.start}")
    return world


def _user_map(options: Mapping[str, Any], radius: float) -> NavigationMap:
    missing = [key for key in _USER_KEYS if key not in options]
    if missing:
        raise ValueError(f"a map of your own needs {', '.join(_USER_KEYS)}; missing: {', '.join(missing)}")
    mixed = [key for key in ("map", "map_seed") if key in options]
    if mixed:
        raise ValueError(f"{', '.join(mixed)} cannot be combined with {', '.join(_USER_KEYS)}")
    obstacles = options["obstacles"]
    if not _is_sequence(obstacles):
        raise ValueError(f"obstacles must be a list of polygons, got {type(obstacles).__name__}")
    return parse_user_map(obstacles, options["start"], options["target"], radius)


def _natural_number(name: str, value: Any) -> int:
    try:
        number = operator.index(value)
    except TypeError:
        number = -1
    if number < 0:
        raise ValueError(f"{name} must be an integer >= 0, got {value!r}")
    return number


def _point(name: str, value: ArrayLike) -> Point:
    array = _float_array(name, value, "two finite coordinates (x, y) in metres")
    if array.shape != (2,) or not np.isfinite(array).all():
        raise ValueError(f"{name} must be two finite coordinates (x, y) in metres, got {value!r}")
    return float(array[0]), float(array[1])


def _polygon(index: int, value: ArrayLike) -> Vertices:
    name = f"obstacles[{index}]"
    expected = "at least three vertices (x, y) in metres, shape (n, 2)"
    array = _float_array(name, value, expected)
    if array.ndim != 2 or array.shape[1] != 2 or len(array) < 3 or not np.isfinite(array).all():
        raise ValueError(f"{name} must be {expected}, all finite; got shape {array.shape}")
    polygon = Polygon(array)
    if not polygon.is_valid or polygon.area == 0.0:
        reason = shapely.is_valid_reason(polygon) if not polygon.is_valid else "no area"
        raise ValueError(f"{name} must be a simple polygon with an area: {reason}")
    return [(float(x), float(y)) for x, y in array]


def _float_array(name: str, value: ArrayLike, expected: str) -> np.ndarray[Any, np.dtype[np.float64]]:
    try:
        return np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{name} must be {expected}, got {value!r}") from error


def _exactly(length: int, name: str, values: Any) -> list[Any]:
    if not _is_sequence(values) or len(values) != length:
        raise ValueError(f"{name} must have one entry for each of the {length} sub-environments, got {values!r}")
    return list(values)


def _is_sequence(value: object) -> bool:
    return isinstance(value, (list, tuple, np.ndarray))
