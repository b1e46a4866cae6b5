"""The potential of the navigation figure is the one whose slope was sampled."""

import numpy as np

from aicon_baselines.figures.nav2d.grid import Grid
from aicon_envs.nav2d import NavigationMap

CORNERS = [(-0.5, -0.4), (0.6, -0.4), (0.6, 0.3), (-0.5, 0.3)]
BLOCK = NavigationMap("block", [CORNERS], (-2.0, 0.0), (2.0, 0.0))


def test_potential_recovers_the_one_that_was_sampled() -> None:
    grid = Grid(BLOCK, np.array([-2.0, -1.0]), np.array([2.0, 1.0]), 0.1)
    x, y = grid.points.T

    # The trapezoidal rule along an edge is exact for a quadratic.
    height = 0.3 * x**2 + 0.2 * x * y - y
    descent = -np.stack([0.6 * x + 0.2 * y, 0.2 * x - 1.0], axis=1)
    fitted = grid.potential(descent)

    assert not grid.free.all()
    assert (np.isnan(fitted) == ~grid.free).all()
    np.testing.assert_allclose(fitted[grid.free], height - height.min(), atol=1e-6)
