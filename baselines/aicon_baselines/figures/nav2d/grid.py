"""Where the figure samples the field, and the potential that the samples fit."""

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy import sparse
from scipy.ndimage import distance_transform_edt
from scipy.sparse.linalg import splu

from aicon_baselines.figures.nav2d.recording import BoolArray, FloatArray, Recording
from aicon_envs.nav2d import NavigationMap
from aicon_envs.nav2d.world import union

_ASPECT = 1.95  # width of a panel over its height
_MARGIN = 0.45  # m of free space around what is shown


class Grid:
    """A rectangular grid over the free space, and the potential that fits a descent field on it best.

    Args:
        world: The map.
        low: Lower left corner (x, y), m.
        high: Upper right corner, m.
        spacing: Distance of neighbours, m.

    Attributes:
        shape: Rows and columns.
        extent: left, right, bottom, top of the picture made of one cell a point, m.
        points: The free points, (N, 2), m.
        free: Which points of the grid lie outside the obstacles, `shape`.
        nearest_free: Row and column of the nearest free point of each point, `shape` each.
    """

    def __init__(self, world: NavigationMap, low: FloatArray, high: FloatArray, spacing: float) -> None:
        self._spacing = spacing
        columns, rows = (np.arange(a, b + spacing / 2, spacing) for a, b in zip(low, high, strict=True))
        self.shape = (len(rows), len(columns))
        half = spacing / 2
        self.extent = (columns[0] - half, columns[-1] + half, rows[0] - half, rows[-1] + half)
        every = np.stack(np.meshgrid(columns, rows), axis=-1)
        self.free: BoolArray = ~shapely.contains_xy(union(world.obstacles), every[..., 0], every[..., 1])
        self.points: FloatArray = every[self.free]
        self.nearest_free = tuple(distance_transform_edt(~self.free, return_distances=False, return_indices=True))
        self._first, self._second, self._axis = _neighbours(self.free)
        links = np.arange(len(self._axis))
        entries = (np.tile(links, 2), np.concatenate([self._second, self._first]))
        signs = np.repeat([1.0, -1.0], len(links))
        self._difference = sparse.csr_array((signs, entries), shape=(len(links), len(self.points)))
        laplacian = self._difference.T @ self._difference
        self._solver = splu((laplacian + 1e-9 * sparse.eye_array(len(self.points))).tocsc())  # fixes the free constant

    def potential(self, descent: FloatArray) -> FloatArray:
        """The heights φ whose slopes fit the field best: min Σ (φⱼ − φᵢ + h (fᵢ + fⱼ)/2)² over neighbours i, j.

        A field that turns about is no potential's; what turns is left out of the fit.

        Args:
            descent: f = −∇, (N, 2).

        Returns:
            φ as an array of the grid's shape, NaN in obstacles, from 0.
        """
        along = descent[self._first, self._axis] + descent[self._second, self._axis]
        heights = self._solver.solve(self._difference.T @ (-0.5 * self._spacing * along))
        return self.fill(heights - heights.min())

    def fill(self, values: FloatArray) -> FloatArray:
        """Values at the free points as an array of the grid's shape, NaN elsewhere."""
        whole = np.full(self.shape, np.nan)
        whole[self.free] = values
        return whole


def _neighbours(free: BoolArray) -> NDArray[np.int64]:
    """For each two neighbours their indices among the free points, and the axis on which they differ, (3, links)."""
    index = np.full(free.shape, -1)
    index[free] = np.arange(free.sum())
    links = []
    for axis, (first, second) in enumerate([(index[:, :-1], index[:, 1:]), (index[:-1], index[1:])]):
        both = (first >= 0) & (second >= 0)
        links.append(np.stack([first[both], second[both], np.full(both.sum(), axis)]))
    return np.concatenate(links, axis=1)


def grid_around(recording: Recording, spacing: float) -> Grid:
    """A grid over the smallest rectangle of a panel's aspect that shows the way, the target and the obstacles."""
    world = recording.world
    points = np.array([*recording.positions, world.target, *(vertex for each in world.obstacles for vertex in each)])
    low, high = points.min(axis=0) - _MARGIN, points.max(axis=0) + _MARGIN
    width, height = high - low
    size = np.array([max(width, _ASPECT * height), max(height, width / _ASPECT)])
    centre = (low + high) / 2
    return Grid(world, centre - size / 2, centre + size / 2, spacing)
