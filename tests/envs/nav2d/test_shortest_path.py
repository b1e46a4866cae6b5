"""The shortest path, against geometry that can be worked out by hand."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely.geometry import box

from aicon_envs.nav2d import MAP_NAMES, make_map, shortest_path_length
from aicon_envs.nav2d.world import to_vertices


def test_without_obstacles_it_is_straight() -> None:
    assert shortest_path_length([], (0.0, 0.0), (3.0, 4.0), 0.1) == pytest.approx(5.0)


def test_around_a_wall() -> None:
    """Two tangents from the ends to a circle around each corner, and two arcs between."""
    half, thickness, radius, away = 1.5, 0.2, 0.1, 2.0
    left, right = -thickness / 2, thickness / 2
    wall = [(left, -half), (right, -half), (right, half), (left, half)]

    inner = away - thickness / 2
    tangent = math.sqrt(inner**2 + half**2 - radius**2)
    arc = radius * (math.atan2(half, inner) + math.asin(radius / math.hypot(inner, half)))
    expected = 2 * (tangent + arc) + thickness

    length = shortest_path_length([wall], (-away, 0.0), (away, 0.0), radius, quad_segs=16)
    assert length == pytest.approx(expected, abs=1e-3)


def test_around_a_square_without_a_radius() -> None:
    square = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
    length = shortest_path_length([square], (-2.0, 0.0), (2.0, 0.0), 0.0)
    assert length == pytest.approx(2.0 * math.sqrt(2.0) + 2.0, abs=1e-4)


def test_there_is_none_into_a_closed_room_or_an_obstacle() -> None:
    room = to_vertices(box(-1, -1, 1, 1) - box(-0.8, -0.8, 0.8, 0.8))
    assert shortest_path_length(room, (0.0, 0.0), (3.0, 0.0), 0.1) == math.inf
    assert shortest_path_length(room, (2.0, 0.0), (0.9, 0.0), 0.1) == math.inf


@settings(max_examples=20, deadline=None)
@given(name=st.sampled_from(MAP_NAMES), seed=st.integers(0, 30), radius=st.floats(0.0, 0.2))
def test_it_is_symmetric_and_grows_with_the_radius(name: str, seed: int, radius: float) -> None:
    world = make_map(name, np.random.default_rng(seed))

    length = shortest_path_length(world.obstacles, world.start, world.target, radius)
    back = shortest_path_length(world.obstacles, world.target, world.start, radius)
    wider = shortest_path_length(world.obstacles, world.start, world.target, radius + 0.04)
    assert math.isfinite(length)
    assert length == pytest.approx(back)
    assert length <= wider + 1e-3
