"""Capsules around a shape: one about some points, or a few that cover a surface."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from aicon_torch.extras import import_extra

WIDENING = (1.0, 1.03, 1.07, 1.12, 1.2, 1.3, 1.45, 1.7, 2.0)
"""Radii that are tried, in least radii: a wider capsule may be shorter, and smaller in the end."""

STANDS_OUT = 0.02
"""A capsule may stand out of a shape by so much, m, before two replace it."""

WORTH_A_SPLIT = 0.95
"""They do if both stand out by less than this share of what the one did."""

HOLLOW = 0.005
"""The hull of a surface may stand out of its capsules by so much, m, which is half the gap that is
kept; where it does by more, they cover the hull as well: physics take meshes for their hulls."""

CUTS = (0.25, 0.375, 0.5, 0.625, 0.75)
"""Where a surface is cut in two, as shares of its extent."""

FACETS = 16
"""Triangles are made smaller than the extent of the surface through this number."""

MOST_PARTS = 300_000
"""They are left larger where there would be more of them than this."""

CORNERS = 256
"""So many points stand for all of them while a capsule is looked for."""

SAMPLE = 1500
"""Some so many triangles stand for all of them while a cut is looked for."""


class Segment(NamedTuple):
    """A capsule: all points that are no further than the radius from a segment.

    Attributes:
        start: One end, ``(3,)``, m.
        end: The other, m.
        radius: m.
    """

    start: NDArray[Any]
    end: NDArray[Any]
    radius: float

    @property
    def volume(self) -> float:
        """V = πr²ℓ + 4/3 πr³, m³."""
        length = float(np.linalg.norm(self.end - self.start))
        return float(_volume(np.array(self.radius), np.array(length)))

    def moved(self, transform: NDArray[Any]) -> "Segment":
        """The same capsule after a rigid motion ``(4, 4)``."""
        rotation, position = transform[:3, :3], transform[:3, 3]
        return Segment(
            rotation @ self.start + position, rotation @ self.end + position, self.radius
        )


def around_cylinder(length: float, radius: float) -> Segment:
    """The smallest capsule along a cylinder about z, whose middle is the origin.

    Its segment is L − 2√(R² − r²) long, so that the rims are on its round ends.
    """
    radii = radius * np.array(WIDENING)
    lengths = (length - 2.0 * np.sqrt(radii**2 - radius**2)).clip(min=0.0)

    # Where nothing remains of the segment, a sphere through the rims.
    radii = np.minimum(radii, np.hypot(radius, length / 2.0))
    best = int(_volume(radii, lengths).argmin())
    end = np.array([0.0, 0.0, lengths[best] / 2.0])
    return Segment(-end, end, float(radii[best]))


def around_points(points: NDArray[Any], directions: int = 64, rounds: int = 12) -> Segment:
    """A small capsule about all points.

    Directions all around are tried, and those near the best in ever smaller steps, each with the
    circle about the points seen along it.

    Args:
        points: ``(N, 3)``, m.
        directions: How many directions are tried at first.
        rounds: How often the best is improved.
    """
    corners = _extreme_points(points)
    axes = np.concatenate((_principal_axes(points), np.eye(3), _hemisphere(directions)))
    generator = np.random.default_rng(0)

    best = _smallest(corners, axes, _circle_centers(corners, axes))
    for step in 0.3 * 0.7 ** np.arange(rounds):
        # Random lines about the best one, nearer and nearer to it.
        axis, center, segment = best
        axes = axis + step * generator.normal(size=(24, 3))
        axes /= np.linalg.norm(axes, axis=1, keepdims=True)
        shifts = 0.3 * step * segment.radius * generator.normal(size=(24, 3))

        other = _smallest(corners, axes, center + shifts)
        best = min(best, other, key=lambda found: found[2].volume)

    # The corners stood for all points.
    axis, center, _ = best
    return _smallest(points, axis[None], center[None])[2]


def around_surfaces(surfaces: Sequence[NDArray[Any]], count: int) -> list[Segment]:
    """A few capsules that cover some surfaces, and the convex hull of each up to :data:`HOLLOW`.

    A bent or waisted surface has a hull that is wider than itself, and wider than the capsules that
    follow it.

    Args:
        surfaces: ``(T, 3, 3)`` each, triangles, m.
        count: At most so many capsules.
    """
    hulls = _Hulls(surfaces)
    triangles = np.concatenate(surfaces)
    segments = _cover(triangles, hulls, count)

    corners = _small_triangles(hulls.faces).reshape(-1, 3)
    if _out_of(segments, corners).max() > HOLLOW:
        segments = _cover(np.concatenate((triangles, hulls.faces)), hulls, count)
    return segments


def _cover(triangles: NDArray[Any], hulls: "_Hulls", count: int) -> list[Segment]:
    """A few capsules that cover triangles ``(T, 3, 3)``.

    Again and again the capsule that stands out most, by more than :data:`STANDS_OUT`, is replaced
    by two: what it covers is cut across, where both stand out least.
    """
    pieces = [_small_triangles(triangles)]
    segments = [around_points(pieces[0].reshape(-1, 3))]
    heights = [hulls.height(segments[0])]  # 0 where nothing is to be gained any more

    # The capsule that stands out most is cut in two, as long as there may be more of them.
    while len(pieces) < count and max(heights) > STANDS_OUT:
        index = int(np.argmax(heights))
        halves = _best_cut(pieces[index], hulls)
        if not all(len(half) for half in halves):
            heights[index] = 0.0
            continue

        fits = [around_points(half.reshape(-1, 3)) for half in halves]
        of_fits = [hulls.height(fit) for fit in fits]

        # A cut has to be worth a capsule more.
        if max(of_fits) > WORTH_A_SPLIT * heights[index]:
            heights[index] = 0.0
            continue

        pieces[index : index + 1] = halves
        segments[index : index + 1] = fits
        heights[index : index + 1] = of_fits
    return segments


def _out_of(segments: Sequence[Segment], points: NDArray[Any]) -> NDArray[Any]:
    """How far points ``(N, 3)`` are out of the nearest capsule, ``(N,)``, m; negative inside."""
    distances: list[NDArray[Any]] = []
    for segment in segments:
        along, offset = segment.end - segment.start, points - segment.start
        square = max(float(along @ along), 1e-12)
        share = (offset @ along / square).clip(0.0, 1.0)
        gap = np.linalg.norm(offset - share[:, None] * along, axis=1)
        distances.append(gap - segment.radius)
    return np.asarray(np.min(distances, axis=0))


class _Hulls:
    """The convex hulls of surfaces: how far something stands out of all of them.

    Args:
        surfaces: ``(T, 3, 3)`` each, triangles, m.

    Attributes:
        faces: Of all of them, ``(F, 3, 3)``, m.
    """

    def __init__(self, surfaces: Sequence[NDArray[Any]]) -> None:
        spatial = import_extra("scipy.spatial", "robots")
        self._planes: list[NDArray[Any]] = []
        faces: list[NDArray[Any]] = []
        for surface in surfaces:
            corners = _with_volume(_extreme_points(surface.reshape(-1, 3)))
            # Shaken a little (QJ), since what lies in a plane has no hull.
            hull = spatial.ConvexHull(corners, qhull_options="QJ")
            self._planes.append(hull.equations)
            faces.append(corners[hull.simplices])
        self.faces = np.concatenate(faces)

    def height(self, segment: Segment) -> float:
        """By how much a capsule stands out, beyond the planes of the hulls' faces, m."""
        points = _surface_of(segment)
        outside = [(points @ planes[:, :3].T + planes[:, 3]).max(axis=1) for planes in self._planes]
        return max(0.0, float(np.min(outside, axis=0).max()))


def _with_volume(corners: NDArray[Any]) -> NDArray[Any]:
    """The corners; where they are those of a segment or a triangle, one of a little thickness."""
    # n corners span n − 1 directions at most; along the others they become that thick.
    thickness = 1e-6 * np.ptp(corners, axis=0).max()
    _, _, axes = np.linalg.svd(corners - corners.mean(axis=0))
    for missing in axes[len(corners) - 1 :]:
        corners = np.concatenate((corners, corners + thickness * missing))
    return corners


def _surface_of(segment: Segment) -> NDArray[Any]:
    """Points all over the surface of a capsule: its round ends, and rings between them."""
    axis = segment.end - segment.start
    half = _hemisphere(48)
    directions = np.concatenate((half, -half))
    is_at_end = (directions @ axis > 0.0)[:, None]
    ends = np.where(is_at_end, segment.end, segment.start) + segment.radius * directions

    # Two directions across the axis, and the circle that they span.
    across = np.linalg.svd(axis[None])[2][1:]
    angle = np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False)
    ring = segment.radius * np.stack((np.cos(angle), np.sin(angle)), axis=1) @ across
    along = segment.start + np.linspace(0.0, 1.0, 9)[:, None] * axis
    return np.concatenate((ends, (along[:, None] + ring).reshape(-1, 3)))


def _best_cut(triangles: NDArray[Any], hulls: _Hulls) -> list[NDArray[Any]]:
    """The two halves of a surface whose capsules stand out least."""
    sample = triangles[:: 1 + len(triangles) // SAMPLE]
    best, least = np.ones(len(triangles), dtype=bool), np.inf

    for axis in np.concatenate((_principal_axes(sample.reshape(-1, 3)), np.eye(3))):
        along = triangles.mean(axis=1) @ axis
        of_sample = sample.mean(axis=1) @ axis

        # Across each axis at several heights; a sample tells which is best.
        for share in CUTS:
            height = of_sample.min() + share * np.ptp(of_sample)
            lower = of_sample < height
            halves = (sample[lower], sample[~lower])
            if not all(len(half) for half in halves):
                continue

            fits = [around_points(half.reshape(-1, 3), directions=8, rounds=0) for half in halves]
            smaller, larger = sorted(hulls.height(fit) for fit in fits)

            # The worse half counts in full, and the better one by half of it.
            if larger + smaller / 2.0 < least:
                best, least = along < height, larger + smaller / 2.0

    return [triangles[best], triangles[~best]]


def _smallest(
    points: NDArray[Any], axes: NDArray[Any], centers: NDArray[Any]
) -> tuple[NDArray[Any], NDArray[Any], Segment]:
    """The smallest capsule about all points that lies on one of D lines, with that line.

    Args:
        points: ``(N, 3)``, m.
        axes: Directions of the lines, ``(D, 3)``.
        centers: A point on each, ``(D, 3)``, m.
    """
    # Where the points are along each line, and how far from it, (D, N).
    offset = points.T[:, None] - centers.T[..., None]  # (3, D, N)
    along = _dot(offset, axes.T[..., None])
    square_across = (_dot(offset, offset) - along**2).clip(min=0.0)

    # On each line the capsules of several radii, (R, D): the least that is possible, and wider.
    least = np.sqrt(square_across.max(axis=1))
    radii = least * np.array(WIDENING)[:, None]
    start, end = _shortest_segments(along, square_across, radii)
    volumes = _volume(radii, end - start)

    row, column = np.unravel_index(int(volumes.argmin()), volumes.shape)
    axis, center = axes[column], centers[column]
    ends = center + start[row, column] * axis, center + end[row, column] * axis
    rounding = 1e-9
    return axis, center, Segment(*ends, float(radii[row, column]) + rounding)


def _shortest_segments(
    along: NDArray[Any], square_across: NDArray[Any], radii: NDArray[Any]
) -> tuple[NDArray[Any], NDArray[Any]]:
    """Where the shortest segments [t₀, t₁] of some radii begin and end on their lines, ``(R, D)``.

    A point at (s, ρ) along and across is within R of the segment if t₀ ≤ s + √(R² − ρ²) and
    t₁ ≥ s − √(R² − ρ²).
    """
    reach = np.sqrt((radii[..., None] ** 2 - square_across).clip(min=0.0))
    start, end = (along + reach).min(axis=-1), (along - reach).max(axis=-1)

    # Where they have passed each other, any point between them is the middle of a sphere.
    middle = (end + start) / 2.0
    return np.minimum(start, middle), np.maximum(end, middle)


def _circle_centers(points: NDArray[Any], axes: NDArray[Any], rounds: int = 60) -> NDArray[Any]:
    """For each axis the middle of the circle about the points seen along it, ``(D, 3)``.

    The middle goes toward the furthest point, by 1/2, 1/3, … of the way (Badoiu and Clarkson 2003).
    """
    centers = np.repeat(points.mean(axis=0)[:, None], len(axes), axis=1)
    points, along = points.T[:, None], axes.T[..., None]  # (3, 1, N), (3, D, 1)
    rows = np.arange(len(axes))

    for number in range(rounds):
        # From each line straight across to the points; the furthest one draws it by its share.
        offset = points - centers[..., None]
        across = offset - _dot(offset, along) * along
        furthest = _dot(across, across).argmax(axis=1)
        centers += across[:, rows, furthest] / (number + 2)
    return centers.T


def _dot(first: NDArray[Any], second: NDArray[Any]) -> NDArray[Any]:
    """The products of vectors ``(3, …)``: components first, numpy is several times as fast."""
    product: NDArray[Any] = first[0] * second[0]
    product += first[1] * second[1]
    product += first[2] * second[2]
    return product


def _extreme_points(points: NDArray[Any]) -> NDArray[Any]:
    """The points that are furthest in some direction, at most :data:`CORNERS`."""
    directions = _hemisphere(CORNERS // 2)
    directions = np.concatenate((directions, -directions))

    # Part by part: what is furthest of all is furthest in its part.
    while len(points) > 8 * CORNERS:
        parts = np.array_split(points, len(points) // (4 * CORNERS))
        points = np.concatenate([part[_furthest(part, directions)] for part in parts])
    return np.asarray(points[_furthest(points, directions)])


def _furthest(points: NDArray[Any], directions: NDArray[Any]) -> NDArray[Any]:
    """Which points are furthest in the directions ``(D, 3)``, each once."""
    furthest: NDArray[np.intp] = np.unique((directions @ points.T).argmax(axis=1))
    return furthest


def _small_triangles(triangles: NDArray[Any]) -> NDArray[Any]:
    """The same surface in triangles that are small against it, so that it can be cut."""
    trimesh = import_extra("trimesh", "robots")
    vertices = triangles.reshape(-1, 3)
    faces = np.arange(len(vertices)).reshape(-1, 3)

    largest = float(np.ptp(vertices, axis=0).max()) / FACETS
    while _count_of_parts(triangles, largest) > max(MOST_PARTS, len(triangles)):
        largest *= 1.25

    vertices, faces = trimesh.remesh.subdivide_to_size(vertices, faces, largest, max_iter=20)
    return np.asarray(vertices[faces])


def _count_of_parts(triangles: NDArray[Any], largest: float) -> float:
    """How many there are once all are cut in four until no edge is longer than ``largest``."""
    edges = np.linalg.norm(triangles - np.roll(triangles, 1, axis=1), axis=-1).max(axis=1)

    # Cut in four, a triangle has edges half as long.
    cuts = np.ceil(np.log2(np.maximum(edges / largest, 1.0)))
    return float((4.0**cuts).sum())


def _principal_axes(points: NDArray[Any]) -> NDArray[Any]:
    """The axes of the points' covariance, ``(3, 3)``, one a row."""
    _, axes = np.linalg.eigh(np.cov(points.T))
    return np.asarray(axes.T)


def _hemisphere(count: int) -> NDArray[Any]:
    """Directions all around, of which no two are opposite, ``(count, 3)``: a Fibonacci spiral."""
    number = np.arange(count)
    height = (number + 0.5) / count

    # By the golden angle, so that no two of the spiral's turns line up.
    angle = number * np.pi * (1.0 + np.sqrt(5.0))

    radius = np.sqrt(1.0 - height**2)
    return np.stack((radius * np.cos(angle), radius * np.sin(angle), height), axis=1)


def _volume(radius: NDArray[Any], length: NDArray[Any]) -> NDArray[Any]:
    """V = πr²ℓ + 4/3 πr³."""
    return np.pi * radius**2 * (length + 4.0 / 3.0 * radius)
