"""Disturbances: kicks that suddenly displace the object."""

import math

import numpy as np
import shapely
from shapely.geometry import Polygon

from aicon_envs.pusht.geometry import Point, Pose, place, place_point
from aicon_envs.pusht.objects import PushObject
from aicon_envs.pusht.simulation import PUSHER_RADIUS, WALL_HIGH, WALL_LOW

_SHARES = (1.0, 0.75, 0.5, 0.25)
"""A kick that does not fit is tried again with less of it."""


def draw_kicked_pose(
    object: PushObject,
    pose: Pose,
    pusher: Point,
    size: tuple[float, float],
    generator: np.random.Generator,
) -> Pose:
    """Return the pose after a kick: shifted within a disc, and turned about the centre of gravity.

    The shift is uniform in the disc of radius `size[0]` px, the turn uniform in ± `size[1]` rad.
    Where the object would touch a wall or the pusher, 3/4, 1/2 or 1/4 of both is taken, or it stays
    where it is.

    Args:
        object: What is kicked.
        pose: Its pose, px and rad.
        pusher: Position of the pusher, px.
        size: Largest shift, px, and turn, rad.
        generator: Gives three numbers.
    """
    # Uniform in the disc: the density of the radius grows with the radius.
    max_shift, max_turn = size
    length = max_shift * math.sqrt(generator.uniform())
    heading = generator.uniform(-math.pi, math.pi)
    turn = max_turn * generator.uniform(-1.0, 1.0)

    for share in _SHARES:
        shift = (share * length * math.cos(heading), share * length * math.sin(heading))
        kicked = _displace(object, pose, shift, share * turn)

        if _is_free(object, kicked, pusher):
            return kicked

    return pose


def _displace(object: PushObject, pose: Pose, shift: Point, turn: float) -> Pose:
    """Shift an object, px, and turn it about its centre of gravity, rad."""
    center = place_point(object.center_of_gravity, pose)
    angle = pose[2] + turn

    # From the frame's origin to the centre of gravity, after the turn.
    lever = place_point(object.center_of_gravity, (0.0, 0.0, angle))
    return center[0] + shift[0] - lever[0], center[1] + shift[1] - lever[1], angle


def _is_free(object: PushObject, pose: Pose, pusher: Point) -> bool:
    """Whether an object touches neither the walls nor the pusher."""
    outline = place(object.outline, pose)
    if outline.min() < WALL_LOW or outline.max() > WALL_HIGH:
        return False

    distance = Polygon(outline).distance(shapely.Point(pusher))
    return bool(distance > PUSHER_RADIUS)
