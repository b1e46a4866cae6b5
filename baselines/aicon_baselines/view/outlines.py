"""Outlines of shapes in the plane, and the triangles that fill them."""

from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def arrow_outline(length: float, width: float) -> FloatArray:
    """Corners of a shaft and a head along the first axis, (7, 2)."""
    head_width = max(2.6 * width, 0.16)
    neck = length - min(1.1 * head_width, 0.6 * length)
    shaft = [(0.0, -width / 2), (neck, -width / 2), (neck, width / 2), (0.0, width / 2)]
    head = [(neck, -head_width / 2), (length, 0.0), (neck, head_width / 2)]
    return np.array(shaft + head)


def triangulate(rings: Sequence[FloatArray]) -> NDArray[np.int_]:
    """Triangles that fill polygons without holes: indices into all their points, (F, 3)."""
    faces, first = [], 0
    for ring in rings:
        pieces = shapely.constrained_delaunay_triangles(shapely.Polygon(ring))
        for triangle in shapely.get_parts(pieces):
            corners = shapely.get_coordinates(triangle)[:3]
            gaps = np.linalg.norm(corners[:, np.newaxis] - ring, axis=-1)
            faces.append(first + gaps.argmin(axis=1))
        first += len(ring)
    return np.array(faces)
