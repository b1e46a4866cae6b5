"""Length of the shortest collision-free path, by a visibility graph."""

from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra
from shapely.geometry.base import BaseGeometry

from aicon_envs.nav2d.world import Point, Vertices, union

FloatArray = NDArray[np.float64]

_SLACK = 1e-6
"""How far a path may cut into the grown obstacles, m; makes paths that touch them count as free."""


def shortest_path_length(
    obstacles: Sequence[Vertices], start: Point, target: Point, radius: float, quad_segs: int = 4
) -> float:
    """Return the length of the shortest path of a disc from `start` to `target`.

    The obstacles are grown by `radius`. The shortest path among polygons bends only at their convex corners, so it is
    the shortest path in the graph of the straight free connections between these corners, start and target.

    Args:
        obstacles: Polygons as lists of vertices, m.
        start: Centre of the disc at the start, m.
        target: Centre of the disc at the end, m.
        radius: Radius of the disc, m.
        quad_segs: Number of chords per quarter circle around the grown corners; the path is at most a share
            1 - sin(h)/h, h = π/(4 quad_segs), of its bends too short: 0.6 % of them with 4.

    Returns:
        The length in metres, or infinity if there is no path.
    """
    grown = union(obstacles).buffer(radius, quad_segs=quad_segs)
    solid = grown.buffer(-_SLACK)
    shapely.prepare(solid)
    ends = np.array([start, target])
    if shapely.intersects(solid, shapely.points(ends)).any():
        return float("inf")
    nodes, before, after = _corners(grown)
    nodes = np.concatenate([ends, nodes])
    before, after = np.concatenate([ends, before]), np.concatenate([ends, after])
    first, second = np.triu_indices(len(nodes), k=1)
    taut = _is_taut(nodes, before, after, first, second) & _is_taut(nodes, before, after, second, first)
    first, second = first[taut], second[taut]
    free = ~shapely.intersects(solid, shapely.linestrings(np.stack([nodes[first], nodes[second]], axis=1)))
    first, second = first[free], second[free]
    length = np.linalg.norm(nodes[first] - nodes[second], axis=1)
    graph = coo_array((length, (first, second)), shape=(len(nodes), len(nodes))).tocsr()
    return float(dijkstra(graph, directed=False, indices=[0])[0, 1])


def _corners(geometry: BaseGeometry) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the convex corners of a (multi-)polygon and the vertices before and after each, (n, 2) each, m."""
    corners, before, after = [np.zeros((0, 2))], [np.zeros((0, 2))], [np.zeros((0, 2))]
    for polygon in shapely.get_parts(geometry):
        for ring in shapely.get_rings(shapely.orient_polygons(polygon)):
            vertices = shapely.get_coordinates(ring)[:-1]
            previous, following = np.roll(vertices, 1, axis=0), np.roll(vertices, -1, axis=0)
            convex = _cross(vertices - previous, following - vertices) > 0.0
            corners.append(vertices[convex])
            before.append(previous[convex])
            after.append(following[convex])
    return np.concatenate(corners), np.concatenate(before), np.concatenate(after)


def _is_taut(
    nodes: FloatArray, before: FloatArray, after: FloatArray, at: NDArray[np.intp], other: NDArray[np.intp]
) -> NDArray[np.bool_]:
    """Whether the line to `other` is tangent to the obstacle `at` a corner: both its edges lie on one side of it."""
    line = nodes[other] - nodes[at]
    sides = _cross(line, before[at] - nodes[at]) * _cross(line, after[at] - nodes[at])
    tangent: NDArray[np.bool_] = sides >= -1e-12
    return tangent


def _cross(first: FloatArray, second: FloatArray) -> FloatArray:
    product: FloatArray = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    return product
