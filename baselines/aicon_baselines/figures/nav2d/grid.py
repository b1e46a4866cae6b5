"""Where the figure samples the field, and the potential that the samples fit."""

import numpy as np
import shapely
from scipy import sparse
from scipy.ndimage import distance_transform_edt
from scipy.sparse.linalg import splu

from aicon_baselines.evaluation.recording import BoolArray, FloatArray
from aicon_envs.nav2d import NavigationMap
from aicon_envs.nav2d.world import union


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
        self._along_x, self._along_y = _differences(self.free)
        self._difference = sparse.vstack([self._along_x, self._along_y])
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
        sums = [abs(self._along_x) @ descent[:, 0], abs(self._along_y) @ descent[:, 1]]
        rises = -0.5 * self._spacing * np.concatenate(sums)
        heights = self._solver.solve(self._difference.T @ rises)
        return self.fill(heights - heights.min())

    def fill(self, values: FloatArray) -> FloatArray:
        """Values at the free points as an array of the grid's shape, NaN elsewhere."""
        filled = np.full(self.shape, np.nan)
        filled[self.free] = values
        return filled


def _differences(free: BoolArray) -> tuple[sparse.csr_array, sparse.csr_array]:
    """Two matrices that map values at the free points to differences of neighbours, φⱼ − φᵢ.

    The first has a row for any two neighbours along x, the second for any two along y.
    """
    rows, columns = free.shape
    of_row, of_column = _difference_of_line(columns), _difference_of_line(rows)
    along_x = sparse.kron(sparse.eye_array(rows), of_row, format="csr")
    along_y = sparse.kron(of_column, sparse.eye_array(columns), format="csr")

    matrices = []
    for matrix in (along_x, along_y):
        # Only where both neighbours are free.
        inner = abs(matrix) @ free.ravel() == 2
        matrices.append(sparse.csr_array(matrix[inner][:, free.ravel()]))
    return matrices[0], matrices[1]


def _difference_of_line(count: int) -> sparse.dia_array:
    """The matrix (count − 1, count) of differences along a line of points."""
    return sparse.diags_array([-1.0, 1.0], offsets=[0, 1], shape=(count - 1, count))
