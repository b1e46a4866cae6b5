"""How an episode starts: what `reset` draws and what its options ask for."""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import shapely
from numpy.typing import ArrayLike

from aicon_envs.arm_push.objects import Prism
from aicon_envs.arm_push.robot import STICK_RADIUS
from aicon_envs.arrays import FloatArray
from aicon_envs.checks import check_numbers, given_options
from aicon_envs.pusht.geometry import place

Bounds = tuple[tuple[float, float], tuple[float, float]]
"""Lower and upper bound of x, and those of y, m."""

AREA: Bounds = ((0.48, 0.60), (-0.15, 0.15))
"""Where centroids of object and target are drawn, m: the arm reaches all sides of the object."""

CONTACT_HEIGHT = 0.02
"""Height of the tip at the start, m: half the objects' thickness."""

_OPTION_KEYS = ("object_pose", "target_pose", "tip", "yaw")

_TIP_AREA: Bounds = ((0.42, 0.66), (-0.22, 0.22))
"""Where the tip starts, m."""

_TIP_GAP = (0.04, 0.12)
"""Bounds of the gap between stick and object, m."""

_MAX_YAW = 0.6
"""Largest angle of the camera's side, rad."""

_ATTEMPTS = 1000

A_POSE = "(x, y, angle), finite, in m and rad"
"""What a pose is, in words."""


class EpisodeStart(NamedTuple):
    """What is fixed at a reset.

    Attributes:
        object_pose: The object's (x, y, θ), m and rad.
        target_pose: Its target.
        tip: Where the tip starts, x and y, m.
        yaw: Angle of the camera's side about the vertical, rad.
    """

    object_pose: FloatArray
    target_pose: FloatArray
    tip: FloatArray
    yaw: float


def draw_episode(
    object: Prism, area: Bounds, options: Mapping[str, Any] | None, generator: np.random.Generator
) -> EpisodeStart:
    """Draw an episode: both poses, the yaw, and a place for the tip unless there is one.

    Args:
        object: What is pushed.
        area: Bounds within which both poses are drawn, m.
        options: `object_pose`, `target_pose`, `tip` and `yaw`, all optional.
        generator: The environment's `np_random`.

    Raises:
        ValueError: If an option is unknown or not usable, or there is no place for the tip.
    """
    options = given_options(options, _OPTION_KEYS)

    # Drawn in any case, such that an option changes nothing but what it names.
    object_pose = _draw_pose(area, generator)
    target_pose = _draw_pose(area, generator)
    yaw = generator.uniform(-_MAX_YAW, _MAX_YAW)

    object_pose = _take(options, "object_pose", object_pose, A_POSE)
    target_pose = _take(options, "target_pose", target_pose, A_POSE)
    (yaw,) = _take(options, "yaw", [yaw], "a finite angle in rad")

    if "tip" in options:
        tip = _take(options, "tip", np.zeros(2), "(x, y), finite, in m")
    else:
        tip = _draw_tip(object, object_pose, generator)

    return EpisodeStart(object_pose, target_pose, tip, float(yaw))


def _take(options: Mapping[str, Any], name: str, drawn: ArrayLike, expected: str) -> FloatArray:
    """Return the numbers of an option, or what was drawn if it is not given."""
    drawn = np.asarray(drawn, np.float64)
    if name not in options:
        return drawn
    return np.array(check_numbers(name, np.atleast_1d(options[name]), expected, len(drawn)))


def check_area(area: Any) -> Bounds:
    """Return bounds in x and y as plain floats.

    Raises:
        ValueError: If they are not two pairs of finite numbers, each in order.
    """
    expected = "((least x, largest x), (least y, largest y)), finite, in m"
    try:
        x, y = area
    except (TypeError, ValueError) as error:
        raise ValueError(f"area must be {expected}, got {area!r}") from error

    x_low, x_high = check_numbers("area", x, expected, 2)
    y_low, y_high = check_numbers("area", y, expected, 2)
    if x_low > x_high or y_low > y_high:
        raise ValueError(f"area must be {expected}, got {area!r}")
    return (x_low, x_high), (y_low, y_high)


def _draw_pose(area: Bounds, generator: np.random.Generator) -> FloatArray:
    x = generator.uniform(*area[0])
    y = generator.uniform(*area[1])
    angle = generator.uniform(-math.pi, math.pi)
    return np.array([x, y, angle])


def _draw_tip(object: Prism, pose: FloatArray, generator: np.random.Generator) -> FloatArray:
    """Draw a place for the tip beside the object, 4 to 12 cm from it."""
    x, y, angle = pose.tolist()
    outline = shapely.Polygon(place(object.corners, (x, y, angle)))
    smallest, largest = _TIP_GAP

    for _ in range(_ATTEMPTS):
        x = generator.uniform(*_TIP_AREA[0])
        y = generator.uniform(*_TIP_AREA[1])

        # Between the stick's surface and the object's side.
        gap = outline.distance(shapely.Point(x, y)) - STICK_RADIUS
        if smallest < gap < largest:
            return np.array([x, y])

    raise ValueError(
        f"object_pose={pose.tolist()}: no place for the tip beside it; name one as the option tip"
    )
