"""The objects to push, as data.

Example:
    >>> from aicon_envs.pusht.objects import OBJECTS, make_object
    >>> OBJECTS["T"].keypoints.shape, OBJECTS["T"].border
    ((8, 2), (0, 1, 2, 5, 6, 7, 4, 3))
    >>> make_object([(0, 0), (90, 0), (0, 90)]).center_of_gravity
    (0.0, 0.0)
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely
from numpy.typing import ArrayLike
from shapely.geometry import Polygon

from aicon_envs.arrays import FloatArray
from aicon_envs.checks import check_vertices
from aicon_envs.pusht.geometry import Point
from aicon_envs.pusht.polygons import convex_parts, signed_area, squared_radius_of_gyration

MIN_AREA = 500.0
"""Smallest area of an object, px²: below this, one sub-step could carry the pusher through it."""

MAX_RADIUS = 90.0
"""Largest distance of a vertex from the centre of gravity, px: all starts are inside the walls."""


@dataclass(frozen=True, eq=False)
class PushObject:
    """A rigid object in the plane. Lengths are in px, in the body's frame.

    Attributes:
        name: Name of the object.
        keypoints: Corners of the outline, (N, 2), in the order of the observation.
        border: Indices of the keypoints in the order in which they walk along the outline, with
            positive signed area.
        parts: Convex polygons, (n, 2) each, with positive signed area, that make up the object
            without overlapping.
        center_of_gravity: About which the object turns.
        mass: Mass.
        inertia: Moment of inertia, mass · px².
    """

    name: str
    keypoints: FloatArray
    border: tuple[int, ...]
    parts: tuple[FloatArray, ...]
    center_of_gravity: Point
    mass: float
    inertia: float

    @property
    def outline(self) -> FloatArray:
        """The corners in the order of `border`, (N, 2), px."""
        return self.keypoints[list(self.border)]

    @property
    def radius_of_gyration(self) -> float:
        """√(inertia / mass), px: a turn by 1 rad counts like a shift by this."""
        return math.sqrt(self.inertia / self.mass)

    @cached_property
    def area(self) -> float:
        """Area, px²."""
        return sum(signed_area(part.tolist()) for part in self.parts)

    @cached_property
    def radius(self) -> float:
        """Largest distance of a corner from the centre of gravity, px."""
        return float(np.linalg.norm(self.keypoints - self.center_of_gravity, axis=1).max())


def make_object(polygon: ArrayLike, name: str = "custom") -> PushObject:
    """Make an object of uniform density and mass 1 from its outline.

    The body's frame has its origin in the centroid, which is the centre of gravity. The keypoints
    are the vertices in the given order.

    Args:
        polygon: At least three vertices (x, y) along the outline of a simple polygon, px, anywhere
            in the plane.
        name: Name of the object.

    Raises:
        ValueError: If the polygon is not simple, its area is below `MIN_AREA` or a vertex is
            farther than `MAX_RADIUS` from the centroid.
    """
    # Vertices in the body's frame.
    shape = _check_polygon(polygon)
    centroid = np.array([shape.centroid.x, shape.centroid.y])
    vertices = shapely.get_coordinates(shape.exterior)[:-1] - centroid

    radius = float(np.linalg.norm(vertices, axis=1).max())
    if radius > MAX_RADIUS:
        raise ValueError(
            f"polygon must lie within {MAX_RADIUS:g} px around its centroid, got {radius:.1f} px"
        )

    # The border walks along the vertices such that the signed area is positive.
    border = tuple(range(len(vertices)))
    if signed_area(vertices.tolist()) <= 0.0:
        border = border[::-1]
    outline = vertices[list(border)]

    return PushObject(
        name=name,
        keypoints=_read_only(vertices),
        border=border,
        parts=tuple(_read_only(part) for part in convex_parts(outline)),
        center_of_gravity=(0.0, 0.0),
        mass=1.0,
        inertia=squared_radius_of_gyration(outline),
    )


def resolve_object(object: "str | PushObject | ArrayLike") -> PushObject:
    """Return an object from its name, itself or its outline.

    Raises:
        ValueError: If no object has this name (the message lists the names), or the outline is not
            usable.
    """
    if isinstance(object, PushObject):
        return object

    if isinstance(object, str):
        if object not in OBJECTS:
            raise ValueError(
                f"object must be one of {', '.join(OBJECTS)}, or a list of vertices (x, y); "
                f"got {object!r}"
            )
        return OBJECTS[object]

    return make_object(object)


def _check_polygon(polygon: ArrayLike) -> Polygon:
    vertices = _check_vertices(polygon)

    shape = Polygon(vertices)
    if not shape.is_valid:
        raise ValueError(f"polygon must be simple: {shapely.is_valid_reason(shape)}")
    if shape.area < MIN_AREA:
        raise ValueError(
            f"polygon must have an area of at least {MIN_AREA:g} px², got {shape.area:.1f}"
        )

    return shape


def _check_vertices(polygon: ArrayLike) -> FloatArray:
    """Return the distinct vertices of a polygon, (n, 2)."""
    vertices = check_vertices("polygon", polygon, "px")

    # shapely and GeoJSON close a ring with its first vertex.
    if (vertices[0] == vertices[-1]).all():
        vertices = vertices[:-1]

    if len(np.unique(vertices, axis=0)) < max(3, len(vertices)):
        raise ValueError(f"the vertices of polygon must be distinct, got {vertices.tolist()}")

    return vertices


def _read_only(points: Iterable[Iterable[float]]) -> FloatArray:
    array = np.array(points, dtype=np.float64)
    array.flags.writeable = False
    return array


def _make_gym_pusht_tee() -> PushObject:
    """Return the T of gym-pusht: keypoints' order, body frame and mass distribution as there.

    gym-pusht takes the mean of the parts' centroids for the centre of gravity (the area's is at
    y = 40.7), and the bar's moment of inertia about the origin, (120² + 30²) / 12 + 15² = 1500, for
    the stem as well (its own is 6375).
    """
    bar = [(-60.0, 0.0), (60.0, 0.0), (60.0, 30.0), (-60.0, 30.0)]
    stem = [(-15.0, 30.0), (15.0, 30.0), (15.0, 120.0), (-15.0, 120.0)]

    return PushObject(
        name="T",
        keypoints=_read_only(bar + stem),
        border=(0, 1, 2, 5, 6, 7, 4, 3),
        parts=(_read_only(bar), _read_only(stem)),
        center_of_gravity=(0.0, 45.0),
        mass=1.0,
        inertia=2.0 * 1500.0,
    )


_OUTLINES: dict[str, list[Point]] = {
    "L": [(0, 0), (30, 0), (30, 90), (90, 90), (90, 120), (0, 120)],
    "U": [(0, 0), (30, 0), (30, 60), (80, 60), (80, 0), (110, 0), (110, 90), (0, 90)],
    "Z": [(0, 0), (80, 0), (80, 40), (120, 40), (120, 80), (40, 80), (40, 40), (0, 40)],
    "H": [
        *[(0, 0), (30, 0), (30, 40), (70, 40), (70, 0), (100, 0)],
        *[(100, 110), (70, 110), (70, 70), (30, 70), (30, 110), (0, 110)],
    ],
    "plus": [
        *[(35, 0), (75, 0), (75, 35), (110, 35), (110, 75), (75, 75)],
        *[(75, 110), (35, 110), (35, 75), (0, 75), (0, 35), (35, 35)],
    ],
    "quadrilateral": [(0, 0), (100, 10), (85, 90), (15, 75)],
}

OBJECTS: dict[str, PushObject] = {
    "T": _make_gym_pusht_tee(),
    **{name: make_object(outline, name) for name, outline in _OUTLINES.items()},
}
"""The named objects; all have an area like the T's, 6300 px², within 30 %."""
