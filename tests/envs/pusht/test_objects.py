"""Properties of the objects to push."""

import math
from typing import Any

import numpy as np
import pymunk
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from shapely.geometry import Polygon

from aicon_envs.pusht import OBJECTS, PushObject, PushTEnv, make_object
from aicon_envs.pusht.objects import MAX_RADIUS, resolve_object
from aicon_envs.pusht.polygons import signed_area

COMB = [
    *[(0, 0), (90, 0), (90, 60), (75, 60), (75, 15), (52, 15)],
    *[(52, 60), (38, 60), (38, 15), (15, 15), (15, 60), (0, 60)],
]
POLYGONS: dict[str, Any] = {
    "triangle": [(0, 0), (90, 0), (0, 90)],
    "comb": COMB,
    "reversed comb": COMB[::-1],
    "far away": [(x + 1e4, y - 1e4) for x, y in COMB],
    "with a point on a side": [(0, 0), (40, 0), (80, 0), (80, 50), (0, 50)],
    "closed": [*COMB, COMB[0]],
    "regular": [
        (60 * math.cos(k * math.tau / 9), 60 * math.sin(k * math.tau / 9)) for k in range(9)
    ],
}
CUSTOM = {name: make_object(polygon, name) for name, polygon in POLYGONS.items()}
ALL = {**OBJECTS, **CUSTOM}
UNIFORM = {name: pushed for name, pushed in ALL.items() if name != "T"}


@pytest.mark.parametrize("pushed", ALL.values(), ids=ALL)
def test_border_walks_once_around_with_positive_area(pushed: PushObject) -> None:
    assert sorted(pushed.border) == list(range(len(pushed.keypoints)))
    assert Polygon(pushed.outline).is_valid
    assert signed_area(pushed.outline.tolist()) == pytest.approx(pushed.area)
    assert pushed.area > 0.0


@pytest.mark.parametrize("pushed", ALL.values(), ids=ALL)
def test_parts_are_convex_do_not_overlap_and_make_up_the_outline(pushed: PushObject) -> None:
    parts = [Polygon(part) for part in pushed.parts]
    for part in parts:
        assert part.convex_hull.area == pytest.approx(part.area)
        assert part.exterior.is_ccw

    difference = shapely.union_all(parts).symmetric_difference(Polygon(pushed.outline))
    assert sum(part.area for part in parts) == pytest.approx(pushed.area)
    assert difference.area == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("pushed", UNIFORM.values(), ids=UNIFORM)
def test_uniform_density_gives_the_masses(pushed: PushObject) -> None:
    """Monte Carlo: the centroid is the origin, the mean squared distance inertia / mass."""
    low, high = pushed.keypoints.min(axis=0), pushed.keypoints.max(axis=0)
    points = np.random.default_rng(0).uniform(low, high, (40_000, 2))
    inside = points[shapely.contains_xy(Polygon(pushed.outline), points)]
    squared_radius = (inside**2).sum(axis=1).mean()

    assert pushed.mass == 1.0 and pushed.center_of_gravity == (0.0, 0.0)
    assert pushed.radius_of_gyration == pytest.approx(math.sqrt(squared_radius), rel=0.01)
    np.testing.assert_allclose(inside.mean(axis=0), 0.0, atol=0.7)


@pytest.mark.parametrize("pushed", UNIFORM.values(), ids=UNIFORM)
def test_inertia_is_that_of_pymunk(pushed: PushObject) -> None:
    expected = 0.0
    for part in pushed.parts:
        mass = signed_area(part.tolist()) / pushed.area
        vertices = [tuple(vertex) for vertex in part.tolist()]
        expected += pymunk.moment_for_poly(mass, vertices)

    assert pushed.inertia == pytest.approx(expected)


def test_the_t_is_that_of_gym_pusht() -> None:
    upstream = pytest.importorskip("gym_pusht.envs.pusht").PushTEnv
    body, shapes = upstream.add_tee(pymunk.Space(), (0, 0), 0)
    tee = OBJECTS["T"]

    np.testing.assert_array_equal(tee.keypoints, upstream.get_keypoints(shapes))
    assert (tee.mass, tee.inertia) == (body.mass, body.moment)
    assert tee.center_of_gravity == tuple(body.center_of_gravity)
    for part, shape in zip(tee.parts, shapes, strict=True):
        np.testing.assert_array_equal(part, shape.get_vertices())
    assert tee.area == 6300.0 and tee.border == (0, 1, 2, 5, 6, 7, 4, 3)


@pytest.mark.parametrize("pushed", OBJECTS.values(), ids=OBJECTS)
def test_named_objects_are_as_large_as_the_t_and_fit(pushed: PushObject) -> None:
    assert 0.7 <= pushed.area / OBJECTS["T"].area <= 1.3
    assert pushed.radius <= MAX_RADIUS


@pytest.mark.parametrize("name", POLYGONS)
def test_a_users_polygon_keeps_its_shape_and_order(name: str) -> None:
    polygon = np.array(POLYGONS[name], dtype=np.float64)
    if name == "closed":
        polygon = polygon[:-1]

    offsets = polygon - make_object(POLYGONS[name]).keypoints
    np.testing.assert_allclose(offsets, np.tile(offsets[0], (len(polygon), 1)), atol=1e-8)


@given(seed=st.integers(0, 10_000), count=st.integers(3, 12))
def test_random_polygons_can_be_pushed(seed: int, count: int) -> None:
    generator = np.random.default_rng(seed)
    angles = (np.arange(count) + generator.uniform(0.0, 0.5, count)) * math.tau / count
    radii = generator.uniform(20.0, 60.0, count)
    polygon = np.stack([radii * np.cos(angles), radii * np.sin(angles)], axis=1)

    areas = [signed_area(part.tolist()) for part in make_object(polygon).parts]
    assert sum(areas) == pytest.approx(Polygon(polygon).area)

    env = PushTEnv(object=polygon)
    env.reset(options={"reset_to_state": [150.0, 256.0, 256.0, 256.0, 0.0]})
    for _ in range(15):
        _, _, _, _, info = env.step(np.array([290.0, 256.0], np.float32))
    assert info["block_pose"][0] > 262.0


def test_arrays_cannot_be_changed_by_accident() -> None:
    for array in (OBJECTS["T"].keypoints, *OBJECTS["L"].parts):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0.0


def test_an_object_goes_by_name_by_outline_and_as_itself() -> None:
    assert resolve_object("L") is OBJECTS["L"]
    assert resolve_object(ALL["comb"]) is ALL["comb"]
    assert resolve_object(COMB).name == "custom"
    assert PushTEnv(object=COMB).object.border == ALL["comb"].border


@pytest.mark.parametrize(
    ("polygon", "words"),
    [
        ([(0, 0), (50, 50)], ["three"]),
        ([(0, 0, 0), (1, 1, 1), (2, 0, 0)], ["shape"]),
        ([(0, 0), (50, 0), (0, math.inf)], ["finite"]),
        ("round", ["vertices"]),
        ([(0, 0), (60, 60), (60, 0), (0, 60)], ["simple", "Self-intersection"]),
        ([(0, 0), (10, 0), (0, 10)], ["area", "500"]),
        ([(0, 0), (200, 0), (200, 30), (0, 30)], ["90", "centroid"]),
        ([(0, 0), (60, 0), (60, 0), (0, 60)], ["distinct"]),
    ],
)
def test_bad_polygons(polygon: Any, words: list[str]) -> None:
    with pytest.raises(ValueError) as error:
        make_object(polygon)
    assert all(word in str(error.value) for word in words), str(error.value)
