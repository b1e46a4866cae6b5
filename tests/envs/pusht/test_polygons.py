"""Areas of polygons, against shapely."""

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from shapely.geometry import Polygon

from aicon_envs.pusht.polygons import overlap_area


@given(scale=st.floats(-12.0, 2.0), seed=st.integers(0, 1000))
def test_overlap_of_polygons_that_almost_coincide(scale: float, seed: int) -> None:
    shift = 10.0**scale * np.random.default_rng(seed).normal(size=2)
    square = np.array([(0.0, 0.0), (50.0, 10.0), (40.0, 60.0), (-10.0, 50.0)])

    expected = shapely.intersection(Polygon(square), Polygon(square + shift)).area
    area = overlap_area((square + shift).tolist(), square.tolist())
    assert area == pytest.approx(expected, abs=1e-9)
