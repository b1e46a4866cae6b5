import numpy as np
import pytest

from aicon_torch.parts import capsule_fit
from aicon_torch.parts.capsule_fit import Segment, around_cylinder, around_points, around_surfaces

GENERATOR = np.random.default_rng(0)


def gap(segment: Segment, points: np.ndarray) -> np.ndarray:
    """How far points ``(N, 3)`` are outside of a capsule; negative inside."""
    along = segment.end - segment.start
    square = max(float(along @ along), 1e-12)
    share = ((points - segment.start) @ along / square).clip(0.0, 1.0)
    nearest = segment.start + share[:, None] * along
    return np.asarray(np.linalg.norm(points - nearest, axis=1) - segment.radius)


def on_sphere(count: int) -> np.ndarray:
    directions = GENERATOR.normal(size=(count, 3))
    return np.asarray(directions / np.linalg.norm(directions, axis=1, keepdims=True))


def test_the_points_of_a_capsule_give_that_capsule() -> None:
    start, end, radius = np.array([0.1, 0.2, 0.3]), np.array([0.4, 0.0, 0.6]), 0.05
    ends = np.where(GENERATOR.random((4000, 1)) < 0.5, start, end)
    found = around_points(ends + radius * on_sphere(4000))

    assert found.volume < 1.1 * Segment(start, end, radius).volume
    assert found.radius == pytest.approx(radius, rel=0.1)


@pytest.mark.parametrize("count", [4, 50, 5000])
def test_all_points_are_inside(count: int) -> None:
    points = GENERATOR.normal(size=(count, 3)) * (0.1, 0.2, 0.5)
    assert gap(around_points(points), points).max() <= 1e-12


def test_points_on_a_sphere_give_a_sphere() -> None:
    found = around_points(0.3 * on_sphere(3000))
    assert found.volume < 1.1 * Segment(np.zeros(3), np.zeros(3), 0.3).volume


@pytest.mark.parametrize(("length", "radius"), [(1.0, 0.1), (0.1, 0.3), (0.2, 0.1)])
def test_a_cylinder_is_inside_its_capsule(length: float, radius: float) -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 100)
    circle = radius * np.stack((np.cos(angle), np.sin(angle)), axis=1)
    rims = [np.column_stack((circle, np.full(100, z))) for z in (-length / 2, length / 2)]

    found = around_cylinder(length, radius)
    assert gap(found, np.concatenate(rims)).max() <= 1e-12
    half = np.array([0.0, 0.0, length / 2])
    assert found.volume <= Segment(-half, half, radius).volume + 1e-15


def bars() -> list[np.ndarray]:
    """The surfaces of an L of two bars, ``(triangles, 3, 3)`` each."""
    trimesh = pytest.importorskip("trimesh")
    upright = trimesh.creation.box(extents=(0.1, 0.1, 1.0))
    lying = trimesh.creation.box(extents=(1.0, 0.1, 0.1))
    lying.apply_translation((0.55, 0.0, -0.45))
    return [np.asarray(upright.triangles), np.asarray(lying.triangles)]


def test_one_capsule_is_replaced_by_two_where_they_fit_better() -> None:
    whole, parts = around_surfaces(bars(), 1), around_surfaces(bars(), 2)
    assert (len(whole), len(parts)) == (1, 2)
    assert sum(part.volume for part in parts) < 0.2 * whole[0].volume


def test_a_surface_that_one_capsule_fits_keeps_one() -> None:
    trimesh = pytest.importorskip("trimesh")
    mesh = trimesh.creation.capsule(height=1.0, radius=0.2)
    assert len(around_surfaces([np.asarray(mesh.triangles)], 4)) == 1


@pytest.mark.parametrize("count", [1, 2, 4])
def test_capsules_cover_the_whole_surface(count: int) -> None:
    shares = GENERATOR.dirichlet(np.ones(3), size=(24, 200))
    points = (shares @ np.concatenate(bars())).reshape(-1, 3)
    gaps = np.stack([gap(part, points) for part in around_surfaces(bars(), count)])
    assert gaps.min(axis=0).max() <= 1e-9


def test_the_hull_of_a_bent_surface_is_covered() -> None:
    """Physics take one mesh for its hull, and two for two hulls."""
    inside = np.array([[0.3, 0.0, 0.0], [0.5, 0.05, -0.1]])  # between the ends of the L
    bent = around_surfaces([np.concatenate(bars())], 4)
    assert min(gap(part, inside).max() for part in bent) < capsule_fit.HOLLOW
    assert min(gap(part, inside).min() for part in around_surfaces(bars(), 4)) > 0.05


def test_a_surface_whose_hull_is_covered_keeps_its_capsules(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Two bars that are two surfaces have each a hull of their own."""
    found = around_surfaces(bars(), 2)
    monkeypatch.setattr(capsule_fit, "HOLLOW", np.inf)
    for segment, other in zip(found, around_surfaces(bars(), 2), strict=True):
        assert np.array_equal(segment.start, other.start)
        assert segment.radius == other.radius


def test_a_single_triangle_is_covered() -> None:
    triangle = np.array([[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]])
    segments = around_surfaces([triangle], count=2)
    for corner in triangle[0]:
        assert min(gap(segment, corner[None]).max() for segment in segments) < 1e-6


def test_a_wire_is_covered() -> None:
    """Seen from all around, only its two ends stand out."""
    wire = GENERATOR.normal(size=(50, 3, 3)) * (1.0, 1e-6, 1e-6)
    segments = around_surfaces([wire], count=2)
    gaps = np.stack([gap(segment, wire.reshape(-1, 3)) for segment in segments])
    assert gaps.min(axis=0).max() <= 1e-9


def test_long_triangles_are_not_cut_into_more_parts_than_the_bound(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(capsule_fit, "MOST_PARTS", 5000)
    triangles = GENERATOR.normal(size=(1000, 3, 3))
    assert len(triangles) < len(capsule_fit._small_triangles(triangles)) <= 5000
