"""The object: its mass properties against shapely and against the environment, and errors."""

import math
from typing import Any

import numpy as np
import pytest
import shapely
import torch
from _inputs.pushing import TRIANGLE, body_of
from numpy.typing import NDArray

from aicon_envs.pusht import OBJECTS
from aicon_torch import OptionError, make_policy
from aicon_torch.models.pusht import PIXEL, Options, rigid_object
from aicon_torch.parts import RigidObject, inward_normal


def random_polygon(seed: int, corners: int) -> NDArray[Any]:
    """A simple polygon, star-shaped about some place."""
    generator = np.random.default_rng(seed)
    angles = generator.uniform(0.0, 2 * np.pi, corners - 3)
    angles = np.sort(np.concatenate((angles, [0.3, 2.4, 4.5])))  # the place lies inside
    radii = generator.uniform(0.02, 0.1, corners)

    polygon: NDArray[Any] = np.stack((radii * np.cos(angles), radii * np.sin(angles)), axis=-1)
    return polygon + generator.uniform(-0.3, 0.3, 2)


def squared_gyration(polygon: shapely.Polygon) -> float:
    """∫|p − c|² dA / A, by triangles: each has A/12 (|a|² + |b|² + |c|² + |a + b + c|²)."""
    middle = np.array([polygon.centroid.x, polygon.centroid.y])
    total = 0.0
    for triangle in shapely.get_parts(shapely.constrained_delaunay_triangles(polygon)):
        corners = shapely.get_coordinates(triangle)[:-1] - middle
        squares = float((corners**2).sum() + (corners.sum(0) ** 2).sum())
        total += triangle.area / 12.0 * squares
    return total / polygon.area


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("sense", [1, -1])
def test_moments_are_those_of_the_polygon(seed: int, sense: int) -> None:
    corners = random_polygon(seed, 3 + seed)
    shape = shapely.Polygon(corners)
    assert shape.is_valid

    body = RigidObject.of(corners.tolist(), list(range(len(corners)))[::sense])
    np.testing.assert_allclose(body.center_of_mass, shapely.get_coordinates(shape.centroid)[0])
    expected = math.sqrt(squared_gyration(shape))
    assert body.radius_of_gyration == pytest.approx(expected, rel=1e-10)
    np.testing.assert_allclose(body.keypoints + body.center_of_mass, corners)


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("sense", [1, -1])
def test_sides_follow_the_outline_with_the_inside_on_their_left(seed: int, sense: int) -> None:
    corners = random_polygon(seed, 3 + seed)
    shape = shapely.Polygon(corners)
    body = RigidObject.of(corners.tolist(), list(range(len(corners)))[::sense])
    assert shapely.Polygon(corners[list(body.outline_order)]).exterior.is_ccw  # with y up

    sides = body.sides(torch.as_tensor(corners))
    lengths = (sides[:, 2:] - sides[:, :2]).norm(dim=-1)
    assert float(lengths.sum()) == pytest.approx(shape.length)

    middles = (sides[:, 2:] + sides[:, :2]) / 2
    for middle, normal in zip(middles, inward_normal(sides), strict=True):
        assert shape.contains(shapely.Point(middle + 1e-6 * normal))
        assert not shape.contains(shapely.Point(middle - 1e-6 * normal))


@pytest.mark.parametrize("name", OBJECTS)
def test_objects_are_those_of_the_environment(name: str) -> None:
    """The T's constants are the benchmark's; a polygon's are what the environment computes."""
    there = OBJECTS[name]
    body = body_of()
    if name != "T":
        body = RigidObject.of((there.keypoints * PIXEL).tolist(), there.border)

    assert body.outline_order == there.border
    keypoints = (body.keypoints + body.center_of_mass) / PIXEL
    np.testing.assert_allclose(keypoints, there.keypoints, atol=1e-9)
    np.testing.assert_allclose(body.center_of_mass / PIXEL, there.center_of_gravity, atol=1e-9)
    assert body.radius_of_gyration / PIXEL == pytest.approx(there.radius_of_gyration)


def test_the_t_is_given_where_nothing_is() -> None:
    body = body_of()
    assert body.outline_order == (0, 1, 2, 5, 6, 7, 4, 3)
    assert body.center_of_mass.tolist() == [0.0, 45 * PIXEL]
    assert body.radius_of_gyration == pytest.approx(3000**0.5 * PIXEL)
    other_sense = rigid_object(Options(outline_order=(3, 4, 7, 6, 5, 2, 1, 0)))
    assert other_sense.outline_order == body.outline_order

    corners = (body.keypoints + body.center_of_mass)[list(body.outline_order)]
    ring = shapely.Polygon(corners)
    assert ring.is_valid
    assert ring.area == pytest.approx((120 * 30 + 90 * 30) * PIXEL**2)


CROSSING = [(0, 0), (0.1, 0.1), (0.1, 0), (0, 0.12)]
BAD: list[tuple[dict[str, Any], str]] = [
    ({"keypoints": [(0, 0), (1, 0)]}, "keypoints.*3 or more"),
    ({"keypoints": [(0, 0), (1, 0), (2, 0)]}, "keypoints.*area"),
    ({"keypoints": [(0, 0, 0), (1, 0, 0), (0, 1, 0)]}, "keypoints"),
    ({"keypoints": [(0, 0), (math.nan, 0), (0, 1)]}, "keypoints"),
    ({"keypoints": [(0, 0), (1,), (0, 1)]}, "keypoints"),
    ({"keypoints": 5}, "keypoints"),
    ({"keypoints": "abc"}, "keypoints"),
    ({"keypoints": CROSSING}, "two sides cross"),
    ({"keypoints": TRIANGLE, "outline_order": (0, 1)}, "outline_order=.*3 keypoints"),
    ({"keypoints": TRIANGLE, "outline_order": (0, 1, 1)}, "outline_order"),
    ({"keypoints": TRIANGLE, "outline_order": 3}, "outline_order=3: .*3 keypoints"),
    ({"keypoints": TRIANGLE, "outline_order": (0, 1, 2.5)}, "outline_order"),
    ({"keypoints": TRIANGLE, "outline_order": "abc"}, "outline_order='abc'"),
    ({"outline_order": (0, 1, 2)}, "outline_order=.*8 keypoints"),
    ({"outline_order": (0, 1, 2, 3, 4, 5, 6, 7)}, "outline_order=.*two sides cross"),
    ({"keypoints": TRIANGLE, "radius_of_gyration": 0.0}, "radius_of_gyration=0.0"),
    ({"keypoints": TRIANGLE, "radius_of_gyration": math.nan}, "radius_of_gyration=nan"),
    ({"keypoints": TRIANGLE, "radius_of_gyration": math.inf}, "radius_of_gyration=inf"),
    ({"keypoints": TRIANGLE, "center_of_mass": (math.nan, 0.0)}, "center_of_mass"),
    ({"keypoints": TRIANGLE, "center_of_mass": (0.0, 0.0, 0.0)}, "center_of_mass"),
]


@pytest.mark.parametrize(("options", "culprit"), BAD, ids=[str(options) for options, _ in BAD])
def test_what_is_no_object_is_named(options: dict[str, Any], culprit: str) -> None:
    with pytest.raises(OptionError, match=culprit):
        make_policy("pusht", **options)
