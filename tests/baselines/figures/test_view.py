"""The rectangle that a view shows."""

import numpy as np
import pytest

from aicon_baselines.figures.view import rectangle_around


@pytest.mark.parametrize("points", [[[0.0, 0.0], [9.0, 1.0]], [[2.0, -3.0], [1.0, 5.0]]])
def test_rectangle_contains_the_points_with_a_margin(points: list[list[float]]) -> None:
    low, high = rectangle_around(np.array(points), margin=0.5, aspect=1.5)
    width, height = high - low

    assert width / height == pytest.approx(1.5)
    assert (low <= np.min(points, axis=0) - 0.5 + 1e-12).all()
    assert (high >= np.max(points, axis=0) + 0.5 - 1e-12).all()
    np.testing.assert_allclose(low + high, np.min(points, axis=0) + np.max(points, axis=0))
