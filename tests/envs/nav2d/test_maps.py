"""Properties of the generated maps."""

import math

import numpy as np
import pytest
import shapely
from numpy.typing import NDArray
from shapely.geometry import LineString, Point, Polygon, box
from shapely.geometry.base import BaseGeometry

from aicon_envs.nav2d import MAP_NAMES, NavigationMap, make_map, shortest_path_length
from aicon_envs.nav2d.maps import check_map_name
from aicon_envs.nav2d.world import union

SEEDS = (0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (1, 2)))
TRAPS = (
    *("u_trap_05", "u_trap_1", "u_trap_2", "u_trap_4"),
    *("ring_inside", "bug_trap", "spiral_in"),
)


def draw(name: str, seed: int) -> NavigationMap:
    return make_map(name, np.random.default_rng(seed))


def free_component(world: NavigationMap, margin: float) -> BaseGeometry:
    """Return the part of the free space, eroded by `margin`, that holds the start."""
    start, target = Point(world.start), Point(world.target)
    grown = union(world.obstacles).buffer(margin)
    extent = box(*shapely.total_bounds([grown, start, target])).buffer(1.0)

    parts = shapely.get_parts(extent.difference(grown))
    component: BaseGeometry = next(part for part in parts if part.contains(start))
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
        assert solid.distance(Point(world.start)) >= 0.4
        assert solid.distance(Point(world.target)) >= 0.4
        assert 3.0 <= math.dist(world.start, world.target) <= 12.0

    def test_blocks_the_straight_way(self, name: str, seed: int) -> None:
        world = draw(name, seed)
        straight_way = LineString([world.start, world.target])
        assert straight_way.intersects(union(world.obstacles))

    def test_has_a_way_half_a_metre_wide(self, name: str, seed: int) -> None:
        world = draw(name, seed)
        assert free_component(world, 0.25).contains(Point(world.target))

        length = shortest_path_length(world.obstacles, world.start, world.target, 0.25)
        assert math.dist(world.start, world.target) <= length < 60.0


def end_of_the_straight_way(
    world: NavigationMap,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the point 2 cm before the first obstacle on the straight way, and its direction."""
    start, target = np.array(world.start), np.array(world.target)
    direction = (target - start) / math.dist(start, target)

    blocked = LineString([start, target]).intersection(union(world.obstacles))
    free_length = blocked.distance(Point(start)) - 0.02
    return start + free_length * direction, direction


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("name", TRAPS)
def test_traps_have_walls_on_both_sides_of_the_place_where_the_straight_way_ends(
    name: str, seed: int
) -> None:
    world = draw(name, seed)
    end, (x, y) = end_of_the_straight_way(world)

    for side in (np.array([-y, x]), np.array([y, -x])):
        assert LineString([end, end + 5.0 * side]).intersects(union(world.obstacles))


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("name", TRAPS)
def test_traps_have_no_way_out_that_only_approaches_the_target(name: str, seed: int) -> None:
    world = draw(name, seed)
    end, _ = end_of_the_straight_way(world)

    radius = math.dist(end, world.target) + 0.05
    nearer = Point(world.target).buffer(radius, quad_segs=64)
    parts = shapely.get_parts(nearer.difference(union(world.obstacles)))
    pockets = [part for part in parts if part.covers(Point(end))]

    assert len(pockets) == 1
    assert not pockets[0].covers(Point(world.target))


@pytest.mark.parametrize(
    ("name", "depth"), [("u_trap_05", 0.5), ("u_trap_1", 1.0), ("u_trap_2", 2.0), ("u_trap_4", 4.0)]
)
def test_u_traps_are_as_deep_as_their_name_says(name: str, depth: float) -> None:
    solid = union(draw(name, 0).obstacles)
    corners = shapely.get_coordinates(solid.minimum_rotated_rectangle)
    sides = np.linalg.norm(np.diff(corners, axis=0), axis=1)
    assert np.abs(sides - depth).min() < 0.2 + 0.05 * depth
