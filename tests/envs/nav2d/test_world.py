"""Polygons with holes become polygons without."""

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely.geometry import Point, Polygon, box

from aicon_envs.nav2d.world import to_vertices


@settings(max_examples=50, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_cutting_holes_keeps_the_area(seed: int) -> None:
    rng = np.random.default_rng(seed)
    holes = []
    for _ in range(6):
        center = Point(rng.uniform(0.0, 4.0, size=2))
        holes.append(center.buffer(rng.uniform(0.1, 0.6)))
    plate = box(0.0, 0.0, 4.0, 4.0).difference(shapely.union_all(holes))

    pieces = [Polygon(vertices) for vertices in to_vertices(plate)]
    assert sum(piece.area for piece in pieces) == pytest.approx(plate.area)
    assert shapely.union_all(pieces).symmetric_difference(plate).area < 1e-9
