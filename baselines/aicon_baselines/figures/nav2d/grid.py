"""Where the figure samples the field, and the potential that the samples fit."""

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy import sparse
from scipy.ndimage import distance_transform_edt
from scipy.sparse.linalg import splu

from aicon_baselines.evaluation.recording import BoolArray, FloatArray
from aicon_baselines.figures.nav2d.recording import NavigationRecording
from aicon_baselines.figures.view import rectangle_around
from aicon_envs.nav2d import NavigationMap
from aicon_envs.nav2d.world import union

_ASPECT = 1.95  # width of a panel over its height
_MARGIN = 0.45  # m of free space around what is shown


class Grid:
    """A rectangular grid over the free space, and the potential that fits a field on it best.

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

    def __init__(
        self, world: NavigationMap, low: FloatArray, high: FloatArray, spacing: float
    ) -> None:
        self._spacing = spacing
        x = np.arange(low[0], high[0] + spacing / 2, spacing)
        y = np.arange(low[1], high[1] + spacing / 2, spacing)
        self.shape = (len(y), len(x))
        half = spacing / 2
        self.extent = (x[0] - half, x[-1] + half, y[0] - half, y[-1] + half)

        # The points outside the obstacles.
        points = np.stack(np.meshgrid(x, y), axis=-1)
        inside = shapely.contains_xy(union(world.obstacles), points[..., 0], points[..., 1])
        self.free: BoolArray = ~inside
        self.points: FloatArray = points[self.free]
        nearest = distance_transform_edt(~self.free, return_distances=False, return_indices=True)
        self.nearest_free = tuple(nearest)

        # The least-squares problem of `potential`, factorised once.
        self._first, self._second, self._axis = _neighbours(self.free)
        self._difference = _difference_matrix(self._first, self._second, len(self.points))
        laplacian = self._difference.T @ self._difference
        regular = laplacian + 1e-9 * sparse.eye_array(len(self.points))  # fixes the free constant
        self._solver = splu(regular.tocsc())

    def potential(self, descent: FloatArray) -> FloatArray:
        """The heights φ whose slopes fit the field best: min Σ (φⱼ − φᵢ + h (fᵢ + fⱼ)/2)².

        The sum is over neighbours i, j. A field that turns about is no potential's; what turns is
        left out of the fit.

        Args:
            descent: f = −∇, (N, 2).

        Returns:
            φ as an array of the grid's shape, NaN in obstacles, from 0.
        """
        along = descent[self._first, self._axis] + descent[self._second, self._axis]
        rises = -0.5 * self._spacing * along
        heights = self._solver.solve(self._difference.T @ rises)
        return self.fill(heights - heights.min())

    def fill(self, values: FloatArray) -> FloatArray:
        """Values at the free points as an array of the grid's shape, NaN elsewhere."""
        filled = np.full(self.shape, np.nan)
        filled[self.free] = values
        return filled


def _neighbours(free: BoolArray) -> NDArray[np.int64]:
    """For any two neighbours their indices among the free points, and their axis, (3, links)."""
    index = np.full(free.shape, -1)
    index[free] = np.arange(free.sum())
    pairs = [(index[:, :-1], index[:, 1:]), (index[:-1], index[1:])]

    links = []
    for axis, (first, second) in enumerate(pairs):
        both = (first >= 0) & (second >= 0)
        links.append(np.stack([first[both], second[both], np.full(both.sum(), axis)]))

    return np.concatenate(links, axis=1)


def _difference_matrix(
    first: NDArray[np.int64], second: NDArray[np.int64], points: int
) -> sparse.csr_array:
    """The matrix that maps values at the points to the differences φⱼ − φᵢ of neighbours."""
    links = len(first)
    rows = np.tile(np.arange(links), 2)
    columns = np.concatenate([second, first])
    signs = np.repeat([1.0, -1.0], links)
    return sparse.csr_array((signs, (rows, columns)), shape=(links, points))


def grid_around(recording: NavigationRecording, spacing: float) -> Grid:
    """A grid over the smallest rectangle of a panel's aspect that shows all there is.

    Args:
        recording: The rollout, whose trajectory, target and obstacles are to be seen.
        spacing: Distance of neighbours, m.
    """
    world = recording.world
    points = [*recording.positions, world.target]
    for vertices in world.obstacles:
        points.extend(vertices)

    low, high = rectangle_around(np.array(points), _MARGIN, _ASPECT)
    return Grid(world, low, high, spacing)
