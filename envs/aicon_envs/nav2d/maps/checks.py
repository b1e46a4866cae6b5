"""What every generated map must fulfil."""

import shapely
from shapely.geometry import LineString, Point, box

from aicon_envs.nav2d.maps.layout import Layout

END_CLEARANCE = 0.4
"""Distance of start and target from every obstacle, m."""

HALF_WIDTH = 0.25
"""Half the width of the way that must exist from start to target, m."""

TRAPS = frozenset(
    {"u_trap_05", "u_trap_1", "u_trap_2", "u_trap_4", "ring_inside", "bug_trap", "spiral_in"}
)
"""Classes whose straight way from start to target must end inside a concavity."""

_INSIDE = 0.05
"""Distance from the boundary of the convex hull from which a point counts as inside it, m."""

_MARGIN = 1.0
"""Free space around obstacles, start and target in which a way may lie, m."""


def is_valid(name: str, layout: Layout) -> bool:
    """Whether the layout is a usable map of class `name`."""
    if not has_room_at_ends(layout) or not is_blocked(layout):
        return False

    if name in TRAPS and not ends_in_concavity(layout):
        return False

    return is_feasible(layout)


def has_room_at_ends(layout: Layout) -> bool:
    """Whether start and target are at least `END_CLEARANCE` from every obstacle."""
    at_start = layout.solid.distance(Point(layout.start))
    at_target = layout.solid.distance(Point(layout.target))
    return min(at_start, at_target) >= END_CLEARANCE


def is_blocked(layout: Layout) -> bool:
    """Whether an obstacle lies on the straight way from start to target."""
    return bool(_straight_way(layout).intersects(layout.solid))


def is_feasible(layout: Layout) -> bool:
    """Whether start and target lie in one component of the free space eroded by `HALF_WIDTH`."""
    start, target = Point(layout.start), Point(layout.target)

    # The free space: everything around the grown obstacles, within a margin.
    grown = layout.solid.buffer(HALF_WIDTH)
    extent = box(*shapely.union_all([grown, start, target]).bounds).buffer(_MARGIN)
    components = shapely.get_parts(extent.difference(grown))

    holds_both = shapely.contains(components, start) & shapely.contains(components, target)
    return bool(holds_both.any())


def ends_in_concavity(layout: Layout) -> bool:
    """Whether the straight way, which must be blocked, meets its first obstacle in a concavity.

    This is where the obstacles' convex hull surrounds the meeting point.
    """
    way = _straight_way(layout)
    free_length = Point(layout.start).distance(way.intersection(layout.solid))
    hit = way.interpolate(free_length)

    hull = layout.solid.convex_hull
    return bool(hull.boundary.distance(hit) > _INSIDE)


def _straight_way(layout: Layout) -> LineString:
    return LineString([layout.start, layout.target])
