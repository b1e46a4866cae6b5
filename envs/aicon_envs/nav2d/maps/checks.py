"""What every generated map must fulfil."""

import shapely
from shapely.geometry import LineString, Point, box

from aicon_envs.nav2d.maps.sketch import Sketch

END_CLEARANCE = 0.4
"""Distance of start and target from every obstacle, m."""

HALF_WIDTH = 0.25
"""Half the width of the way that must exist from start to target, m."""

TRAPS = frozenset({"u_trap_05", "u_trap_1", "u_trap_2", "u_trap_4", "ring_inside", "bug_trap", "spiral_in"})
"""Classes whose straight way from start to target must end inside a concavity."""


def is_valid(name: str, sketch: Sketch) -> bool:
    """Whether the sketch is a usable map of class `name`."""
    if min(sketch.solid.distance(Point(end)) for end in (sketch.start, sketch.target)) < END_CLEARANCE:
        return False
    return _is_blocked(sketch) and (name not in TRAPS or ends_in_concavity(sketch)) and is_feasible(sketch)


def is_feasible(sketch: Sketch) -> bool:
    """Whether start and target lie in the same component of the free space eroded by `HALF_WIDTH`."""
    ends = [Point(sketch.start), Point(sketch.target)]
    grown = sketch.solid.buffer(HALF_WIDTH)
    extent = box(*shapely.union_all([grown, *ends]).bounds).buffer(1.0)
    return any(all(part.contains(end) for end in ends) for part in shapely.get_parts(extent.difference(grown)))


def ends_in_concavity(sketch: Sketch) -> bool:
    """Whether the straight way, which must be blocked, meets its first obstacle inside the obstacles' convex hull."""
    way = _straight(sketch)
    hit = way.interpolate(Point(sketch.start).distance(way.intersection(sketch.solid)))
    return bool(sketch.solid.convex_hull.boundary.distance(hit) > 0.05)


def _is_blocked(sketch: Sketch) -> bool:
    return bool(_straight(sketch).intersects(sketch.solid))


def _straight(sketch: Sketch) -> LineString:
    return LineString([sketch.start, sketch.target])
