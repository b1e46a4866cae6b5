"""Shapes in the plane."""

from collections.abc import Iterator

import numpy as np
import pytest

pytest.importorskip("viser", reason="the live view needs the extra [view]")

from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.palette import OBSTACLE, rgb
from aicon_baselines.view.canvas import Canvas, triangulate
from aicon_baselines.view.server import serve
from aicon_baselines.worlds import arrow, disc


@pytest.fixture
def canvas() -> Iterator[Canvas]:
    """A canvas whose y points down."""
    server = serve("127.0.0.1", 0)
    yield Canvas(server, flipped=True)
    server.stop()


def test_a_place_of_the_scene_is_one_of_the_world(canvas: Canvas) -> None:
    canvas.fit((100.0, 0.0), (300.0, 100.0))
    points = np.array([[100.0, 0.0], [150.0, 80.0]])
    placed = canvas.to_scene(points)
    np.testing.assert_allclose([canvas.to_world(point) for point in placed], points)
    assert placed[0, 1] > placed[1, 1]  # y points down in the world, up in the scene


def test_triangles_cover_a_polygon_that_is_not_convex() -> None:
    corner = np.array([(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)], np.float64)

    area = 0.0
    for a, b, c in corner[triangulate(corner)]:
        (x1, y1), (x2, y2) = b - a, c - a
        area += 0.5 * abs(x1 * y2 - x2 * y1)
    assert area == pytest.approx(5.0)


def test_a_shape_may_get_other_corners(canvas: Canvas) -> None:
    for along in ((1.0, 0.0), (0.0, 1.0)):
        canvas.draw({"way": arrow((0.0, 0.0), along, 0.1, 0.3, 1, OBSTACLE)})
    canvas.draw({"way": disc((0.0, 0.0), 1.0, 1, OBSTACLE)})
    canvas.clear()
    canvas.hide("way")  # there is none, which is no error


def test_an_arrow_ends_at_its_tip() -> None:
    points = arrow((1.0, 2.0), (3.0, 0.0), 0.1, 0.4, 1, OBSTACLE).points
    np.testing.assert_allclose(points.max(axis=0), (4.0, 2.2))
    np.testing.assert_allclose(points.min(axis=0), (1.0, 1.8))


def test_an_address_that_is_none_of_this_machine_is_refused() -> None:
    with pytest.raises(ComparisonError, match=r"cannot listen at '192\.0\.2\.1'"):
        serve("192.0.2.1", 8080)


def test_a_colour_of_another_form_is_an_error_that_shows_the_form() -> None:
    with pytest.raises(ValueError, match=r"color='white': expected one such as '#0059a8'"):
        rgb("white")
