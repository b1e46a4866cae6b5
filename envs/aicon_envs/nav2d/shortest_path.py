"""Length of the shortest collision-free path, by a visibility graph."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra
from shapely.geometry.base import BaseGeometry

from aicon_envs.arrays import BoolArray, FloatArray
from aicon_envs.nav2d.world import Point, Vertices, union

Indices = NDArray[np.intp]

_SLACK = 1e-6
"""How far a path may cut into the grown obstacles, m; makes paths that touch them count as free."""

_SAME_SIDE = -1e-12
"""Two points are on one side of a line if the product of their cross products is at least this."""


def shortest_path_length(
    obstacles: Sequence[Vertices], start: Point, target: Point, radius: float, quad_segs: int = 4
) -> float:
    """Return the length of the shortest path of a disc from `start` to `target`.

    The obstacles are grown by `radius`. The shortest path among polygons bends only at their convex
    corners, so it is the shortest path in the graph of the straight free connections between these
    corners, start and target.

    Args:
        obstacles: Polygons as lists of vertices, m.
        start: Centre of the disc at the start, m.
        target: Centre of the disc at the end, m.
        radius: Radius of the disc, m.
        quad_segs: Number of chords per quarter circle around the grown corners; the path is at most
            a share 1 - sin(h)/h, h = π/(4 quad_segs), of its bends too short: 0.6 % of them with 4.

    Returns:
        The length in metres, or infinity if there is no path.
    """
    # For the centre of the disc, the obstacles are larger by the radius.
    grown = union(obstacles).buffer(radius, quad_segs=quad_segs)
    solid = grown.buffer(-_SLACK)
    shapely.prepare(solid)

    ends = np.array([start, target])
    if shapely.intersects(solid, shapely.points(ends)).any():
        return float("inf")

    # Nodes 0 and 1 are start and target. They have no edges, so they are their own neighbours.
    corners = _convex_corners(grown)
    nodes = np.concatenate([ends, corners.position])
    before = np.concatenate([ends, corners.before])
    after = np.concatenate([ends, corners.after])

    # Of all pairs of nodes, keep those that are tangent at both ends...
    first, second = np.triu_indices(len(nodes), k=1)
    taut = _is_tangent(nodes, before, after, first, second)
    taut &= _is_tangent(nodes, before, after, second, first)
    first, second = first[taut], second[taut]

    # ... and whose connection is free.
    connections = shapely.linestrings(np.stack([nodes[first], nodes[second]], axis=1))
    free = ~shapely.intersects(solid, connections)
    first, second = first[free], second[free]

    length = np.linalg.norm(nodes[first] - nodes[second], axis=1)
    graph = coo_array((length, (first, second)), shape=(len(nodes), len(nodes))).tocsr()
    return float(dijkstra(graph, directed=False, indices=[0])[0, 1])


class _Corners(NamedTuple):
    """Corners of polygons, (n, 2), m.

    Attributes:
        position: The corners themselves.
        before: The vertex before each along its ring.
        after: The vertex after it.
    """

    position: FloatArray
    before: FloatArray
    after: FloatArray


def _convex_corners(geometry: BaseGeometry) -> _Corners:
    """Return the convex corners of a (multi-)polygon."""
    found: list[FloatArray] = [np.zeros((3, 0, 2))]

    for polygon in shapely.get_parts(geometry):
        for ring in shapely.get_rings(shapely.orient_polygons(polygon)):
            # Oriented such that solid lies to the left: at a convex corner the ring turns left.
            vertices = shapely.get_coordinates(ring)[:-1]
            before = np.roll(vertices, 1, axis=0)
            after = np.roll(vertices, -1, axis=0)

            convex = _cross(vertices - before, after - vertices) > 0.0
            found.append(np.stack([vertices, before, after])[:, convex])

    return _Corners(*np.concatenate(found, axis=1))


def _is_tangent(
    nodes: FloatArray, before: FloatArray, after: FloatArray, at: Indices, other: Indices
) -> BoolArray:
    """Whether the line from each corner `at` to `other` is tangent to the obstacle at the corner.

    It is where both edges of the corner lie on one side of the line.
    """
    line = nodes[other] - nodes[at]
    side_before = _cross(line, before[at] - nodes[at])
    side_after = _cross(line, after[at] - nodes[at])

    return side_before * side_after >= _SAME_SIDE


def _cross(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the cross products of vectors (n, 2), (n,)."""
    return first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
