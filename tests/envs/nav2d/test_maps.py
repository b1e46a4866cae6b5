"""Properties of the generated maps and of the shortest path."""

import math

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from shapely.geometry import LineString, Point, Polygon, box
from shapely.geometry.base import BaseGeometry

from aicon_envs.nav2d import MAP_NAMES, NavigationMap, make_map, shortest_path_length
from aicon_envs.nav2d.maps import check_map_name
from aicon_envs.nav2d.world import to_vertices, union

SEEDS = (0, 1, 2)
TRAPS = ("u_trap_05", "u_trap_1", "u_trap_2", "u_trap_4", "ring_inside", "bug_trap", "spiral_in")


def draw(name: str, seed: int) -> NavigationMap:
    return make_map(name, np.random.default_rng(seed))


def free_component(world: NavigationMap, margin: float) -> BaseGeometry:
    """Return the part of the free space, eroded by `margin`, that holds the start."""
    grown = union(world.obstacles).buffer(margin)
    extent = box(*shapely.total_bounds([grown, Point(world.start), Point(world.target)])).buffer(1.0)
    parts = shapely.get_parts(extent.difference(grown))
    component: BaseGeometry = next(part for part in parts if part.contains(Point(world.start)))
    return component


def test_the_classes() -> None:
    assert len(MAP_NAMES) == 16
    assert check_map_name("mixed") == "mixed"
    assert draw("u_trap", 0) == draw("u_trap_2", 0)
    with pytest.raises(ValueError, match="u_trap_05"):
        draw("u_trap_3", 0)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("name", [*MAP_NAMES, "mixed"])
class TestEveryMap:
    def test_comes_from_its_seed_alone(self, name: str, seed: int) -> None:
        assert draw(name, seed) == draw(name, seed)
        assert draw(name, seed) != draw(name, seed + 100)

    def test_consists_of_simple_polygons(self, name: str, seed: int) -> None:
        for vertices in draw(name, seed).obstacles:
            polygon = Polygon(vertices)
            assert polygon.is_valid and polygon.area > 0.0

    def test_has_room_around_start_and_target(self, name: str, seed: int) -> None:
        world = draw(name, seed)
        solid = union(world.obstacles)
        assert min(solid.distance(Point(world.start)), solid.distance(Point(world.target))) >= 0.4
        assert 3.0 <= math.dist(world.start, world.target) <= 12.0

    def test_blocks_the_straight_way(self, name: str, seed: int) -> None:
        world = draw(name, seed)
        assert LineString([world.start, world.target]).intersects(union(world.obstacles))

    def test_has_a_way_half_a_metre_wide(self, name: str, seed: int) -> None:
        world = draw(name, seed)
        assert free_component(world, 0.25).contains(Point(world.target))
        length = shortest_path_length(world.obstacles, world.start, world.target, 0.25)
        assert math.dist(world.start, world.target) <= length < 60.0


def end_of_the_straight_way(world: NavigationMap) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the point 2 cm before the first obstacle on the straight way to the target, and the way's direction."""
    start, target = np.array(world.start), np.array(world.target)
    direction = (target - start) / math.dist(start, target)
    blocked = LineString([start, target]).intersection(union(world.obstacles))
    return start + (blocked.distance(Point(start)) - 0.02) * direction, direction


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("name", TRAPS)
def test_traps_have_walls_on_both_sides_of_the_place_where_the_straight_way_ends(name: str, seed: int) -> None:
    world = draw(name, seed)
    end, direction = end_of_the_straight_way(world)
    for side in (np.array([-direction[1], direction[0]]), np.array([direction[1], -direction[0]])):
        assert LineString([end, end + 5.0 * side]).intersects(union(world.obstacles))


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("name", TRAPS)
def test_traps_have_no_way_out_that_only_approaches_the_target(name: str, seed: int) -> None:
    world = draw(name, seed)
    end, _ = end_of_the_straight_way(world)
    nearer = Point(world.target).buffer(math.dist(end, world.target) + 0.05, quad_segs=64)
    pockets = [part for part in shapely.get_parts(nearer.difference(union(world.obstacles))) if part.covers(Point(end))]
    assert len(pockets) == 1
    assert not pockets[0].covers(Point(world.target))


@pytest.mark.parametrize(
    ("name", "depth"), [("u_trap_05", 0.5), ("u_trap_1", 1.0), ("u_trap_2", 2.0), ("u_trap_4", 4.0)]
)
def test_u_traps_are_as_deep_as_their_name_says(name: str, depth: float) -> None:
    world = draw(name, 0)
    solid = union(world.obstacles)
    extents = shapely.get_coordinates(solid.minimum_rotated_rectangle)
    sides = np.linalg.norm(np.diff(extents, axis=0), axis=1)
    assert np.abs(sides - depth).min() < 0.2 + 0.05 * depth


# --- shortest path


def test_the_shortest_path_without_obstacles_is_straight() -> None:
    assert shortest_path_length([], (0.0, 0.0), (3.0, 4.0), 0.1) == pytest.approx(5.0)


def test_the_shortest_path_around_a_wall() -> None:
    """Two tangents from the ends to a circle of the radius around each corner, and two arcs between."""
    half, thickness, radius, away = 1.5, 0.2, 0.1, 2.0
    wall = [(-thickness / 2, -half), (thickness / 2, -half), (thickness / 2, half), (-thickness / 2, half)]
    inner = away - thickness / 2
    tangent = math.sqrt(inner**2 + half**2 - radius**2)
    arc = radius * (math.atan2(half, inner) + math.asin(radius / math.hypot(inner, half)))
    expected = 2 * (tangent + arc) + thickness
    length = shortest_path_length([wall], (-away, 0.0), (away, 0.0), radius, quad_segs=16)
    assert length == pytest.approx(expected, abs=1e-3)


def test_the_shortest_path_around_a_square_without_a_radius() -> None:
    square = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
    length = shortest_path_length([square], (-2.0, 0.0), (2.0, 0.0), 0.0)
    assert length == pytest.approx(2.0 * math.sqrt(2.0) + 2.0, abs=1e-4)


def test_there_is_no_path_into_a_closed_room_or_an_obstacle() -> None:
    room = to_vertices(box(-1, -1, 1, 1) - box(-0.8, -0.8, 0.8, 0.8))
    assert shortest_path_length(room, (0.0, 0.0), (3.0, 0.0), 0.1) == math.inf
    assert shortest_path_length(room, (2.0, 0.0), (0.9, 0.0), 0.1) == math.inf


@settings(max_examples=20, deadline=None)
@given(name=st.sampled_from(MAP_NAMES), seed=st.integers(0, 30), radius=st.floats(0.0, 0.2))
def test_the_shortest_path_is_symmetric_and_grows_with_the_radius(name: str, seed: int, radius: float) -> None:
    world = draw(name, seed)
    length = shortest_path_length(world.obstacles, world.start, world.target, radius)
    assert math.isfinite(length)
    assert length == pytest.approx(shortest_path_length(world.obstacles, world.target, world.start, radius))
    assert length <= shortest_path_length(world.obstacles, world.start, world.target, radius + 0.04) + 1e-3


@settings(max_examples=50, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_cutting_holes_keeps_the_area(seed: int) -> None:
    rng = np.random.default_rng(seed)
    holes = [Point(rng.uniform(0.0, 4.0, size=2)).buffer(rng.uniform(0.1, 0.6)) for _ in range(6)]
    plate = box(0.0, 0.0, 4.0, 4.0).difference(shapely.union_all(holes))
    pieces = [Polygon(vertices) for vertices in to_vertices(plate)]
    assert sum(piece.area for piece in pieces) == pytest.approx(plate.area)
    assert shapely.union_all(pieces).symmetric_difference(plate).area < 1e-9
