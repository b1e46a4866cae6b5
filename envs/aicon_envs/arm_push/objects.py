"""The objects to push: those of pushT, in metres, and as thick as a hand can push."""

from dataclasses import dataclass

from numpy.typing import ArrayLike

from aicon_envs.arrays import FloatArray
from aicon_envs.checks import check_vertices
from aicon_envs.pusht import objects as planar
from aicon_envs.pusht.objects import OBJECTS, PushObject, make_object

PIXELS_PER_METRE = 600.0
"""One metre in the units of pushT, whose T is 120 px wide; here it is 0.2 m wide."""

THICKNESS = 0.04
"""Height of every object, m."""

OBJECT_NAMES: tuple[str, ...] = tuple(OBJECTS)
"""Names of the objects."""


@dataclass(frozen=True, eq=False)
class Prism:
    """An object of uniform density; lengths in m.

    The origin of its frame is in the centroid, at half its height.

    Attributes:
        name: Its name.
        corners: The outline, ``(N, 2)``, with positive signed area.
        parts: Convex polygons ``(n, 2)`` that make it up.
        radius: Largest distance of a corner from the origin.
    """

    name: str
    corners: FloatArray
    parts: tuple[FloatArray, ...]
    radius: float


def resolve_object(object: str | Prism | ArrayLike) -> Prism:
    """Return an object from its name, itself, or its outline in m.

    Raises:
        ValueError: If no object has this name (the message lists the names), or the outline is not
            usable.
    """
    if isinstance(object, Prism):
        return object

    if isinstance(object, str):
        # Made anew from its outline: here every object has uniform density, the T too.
        return _to_prism(make_object(planar.resolve_object(object).outline, object))

    outline = PIXELS_PER_METRE * check_vertices("object", object, "m")
    try:
        return _to_prism(make_object(outline))
    except ValueError as error:
        raise ValueError(f"object, of which {PIXELS_PER_METRE:g} px are 1 m: {error}") from error


def _to_prism(planar: PushObject) -> Prism:
    return Prism(
        name=planar.name,
        corners=planar.outline / PIXELS_PER_METRE,
        parts=tuple(part / PIXELS_PER_METRE for part in planar.parts),
        radius=planar.radius / PIXELS_PER_METRE,
    )
