"""The boundaries of the obstacles of N worlds as segments, and the boundary point nearest to each.

A segment is a + t d with t in [0, 1]. All are held as one array (3, 2, N, S) of a, d and d / |d|²,
which projects a point onto the segment, each by (x, y). Worlds with fewer than S segments are
padded with segments that lie out of every sensor's range.
"""

from collections.abc import Sequence

import numpy as np
import shapely

from aicon_envs.arrays import FloatArray
from aicon_envs.nav2d.world import Vertices, union

_FAR = 1e9
"""Where padding segments lie, m."""


class Boundaries:
    """The boundary segments of N worlds.

    Args:
        num_worlds: Number N of worlds, all empty at first.
    """

    def __init__(self, num_worlds: int) -> None:
        """Prepare `num_worlds` empty worlds."""
        self._worlds = np.arange(num_worlds)
        self._segments = _padding(num_worlds, 1)

    def load(self, indices: Sequence[int], obstacles: Sequence[list[Vertices]]) -> None:
        """Replace the obstacles of the worlds `indices`."""
        loaded = [boundary_segments(polygons) for polygons in obstacles]
        most = max(segments.shape[2] for segments in loaded)

        # When all worlds are replaced, the room for segments may also shrink.
        if len(indices) < len(self._worlds):
            self._grow(most)
        else:
            self._segments = _padding(len(self._worlds), max(most, 1))

        # What the last map leaves over becomes padding.
        for index, segments in zip(indices, loaded, strict=True):
            count = segments.shape[2]
            self._segments[:, :, index] = _padding(1, self._segments.shape[3])[:, :, 0]
            self._segments[:, :, index, :count] = segments

    def nearest(self, position: FloatArray) -> FloatArray:
        """Return the vectors from positions (2, N) to the nearest boundary points, (2, N), m."""
        start, direction, projection = self._segments
        offset = position[:, :, np.newaxis] - start

        # How far along each segment its nearest point lies: t = clip((p - a)ᵀ d / |d|², 0, 1).
        products = offset * projection
        along = products[0] + products[1]
        np.maximum(along, 0.0, out=along)
        np.minimum(along, 1.0, out=along)

        # From there to the position; the shortest of these vectors wins.
        offset -= along * direction
        squared = offset * offset
        closest = (squared[0] + squared[1]).argmin(axis=1)

        nearest: FloatArray = -offset[:, self._worlds, closest]
        return nearest

    def _grow(self, size: int) -> None:
        """Make room for `size` segments a world, and keep the ones that are there."""
        kept = self._segments
        if size <= kept.shape[3]:
            return

        self._segments = _padding(len(self._worlds), size)
        self._segments[:, :, :, : kept.shape[3]] = kept


def boundary_segments(obstacles: list[Vertices]) -> FloatArray:
    """Return the boundary of the union of polygons as segments, (3, 2, S), as in this module."""
    rings = shapely.get_rings(shapely.get_parts(union(obstacles)))
    if len(rings) == 0:
        return np.zeros((3, 2, 0))

    starts, directions = [], []
    for ring in rings:
        closed = shapely.get_coordinates(ring)
        starts.append(closed[:-1])
        directions.append(np.diff(closed, axis=0))

    start = np.concatenate(starts).T
    direction = np.concatenate(directions).T

    # Repeated vertices make segments of no length, which add nothing.
    squared_length = (direction**2).sum(axis=0)
    proper = squared_length > 0.0
    projection = direction / np.where(proper, squared_length, 1.0)
    return np.stack([start, direction, projection])[:, :, proper]


def _padding(num_worlds: int, size: int) -> FloatArray:
    """Return segments of no length at (_FAR, 0)."""
    segments = np.zeros((3, 2, num_worlds, size))
    segments[0, 0] = _FAR
    return segments
