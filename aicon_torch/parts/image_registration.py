"""Where an object of known outline is in an image: registration of the edges of its top face.

Dense numpy, one image at a time. What a graph reads are the corners that come out.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from aicon_torch.parts.camera import Intrinsics
from aicon_torch.parts.image_segmentation import (
    RGBDImage,
    TopFace,
    TopFaceSegmentation,
    is_colored,
    thin,
)
from aicon_torch.parts.polygon import Array, contains, place, signed_distance

FIT_TOLERANCE = 0.006
"""An edge fits, and a surface point is inside, within this of the outline, m."""

SAMPLE_SPACING = 0.012
"""Distance of the samples of the surface that should be visible, m."""

SAMPLE_INSET = 0.008
"""How far inside the outline these are, m."""

SEARCH_EDGE_POINTS = 60
"""About how many edge points a search uses."""

FIRST_SCALE = 0.04
"""Distance of an edge point beyond which it hardly counts in the first half of a fit, m."""

LAST_SCALE = 0.01
"""That distance in the second half, m: what is far off then belongs to something else."""


class Detection(NamedTuple):
    """What an image shows of the object.

    Attributes:
        pose: Its (x, y, θ), m and rad.
        height: Height of its top face, m.
        score: Share of the visible outline and surface that fits, 0 to 1.
        middle: Middle of what is seen of it, ``(2,)``, m.
    """

    pose: Array
    height: float
    score: float
    middle: Array


@dataclass(frozen=True)
class ImageRegistration:
    """Finds an object of known outline: near where it is expected, or else in all orientations.

    Attributes:
        corners: The outline about the object's frame, in order, ``(N, 2)``, m.
        intrinsics: Of the camera.
        accept: Score from which a registration that starts at the prior is taken as it is.
        fewest: Fewest edge points.
        orientations: How many of them a search tries.
        rounds: Most steps of Gauss-Newton.
    """

    corners: Array
    intrinsics: Intrinsics
    accept: float = 0.85
    fewest: int = 12
    orientations: int = 16
    rounds: int = 10

    def __call__(self, image: RGBDImage, prior: Array | None) -> Detection | None:
        """Find the object.

        Args:
            image: The image.
            prior: Its expected pose (x, y, θ) ``(3,)``, m and rad; None if nothing is known.

        Returns:
            What the image shows; None if it shows too little of the object.
        """
        face = TopFaceSegmentation(self.intrinsics, self.fewest)(image)
        if face is None:
            return None

        expected = None if prior is None else self.fit(prior, image, face)
        if expected is not None and expected.score >= self.accept:
            return expected
        return self.search(image, face, expected)

    def search(self, image: RGBDImage, face: TopFace, best: Detection | None) -> Detection:
        """The best fit from starts in all orientations, or from the best so far."""
        coarse = face._replace(edges=thin(face.edges, SEARCH_EDGE_POINTS))
        x, y = face.surface.mean(0)

        for angle in np.arange(self.orientations) * 2 * np.pi / self.orientations:
            found = self.fit(np.array([x, y, angle]), image, coarse)
            if best is None or found.score > best.score:
                best = found

        assert best is not None  # there is more than one orientation
        return self.fit(best.pose, image, face)

    def fit(self, start: Array, image: RGBDImage, face: TopFace) -> Detection:
        """Gauss-Newton on the distance of edge points to the nearest side of the outline."""
        pose = np.array(start, dtype=np.float64)
        for iteration in range(self.rounds):
            scale = FIRST_SCALE if iteration < self.rounds // 2 else LAST_SCALE
            step = self._gauss_newton_step(pose, face.edges, scale)
            pose += step
            if np.abs(step).max() < 1e-5:
                break

        score = self.score(pose, image, face)
        return Detection(pose, face.height, score, face.surface.mean(0))

    def _gauss_newton_step(self, pose: Array, edges: Array, scale: float) -> Array:
        """The change of the pose, ``(3,)``, that fits the edge points best, with Cauchy weights."""
        distance, normal = signed_distance(edges, self.placed(pose))
        weight = 1.0 / (1.0 + (distance / (0.3 * scale)) ** 2)

        # A point moves with the outline by (dx, dy) and by dθ × its arm.
        arm = edges - pose[:2]
        by_angle = arm[:, 0] * normal[:, 1] - arm[:, 1] * normal[:, 0]
        jacobian = np.column_stack((normal, by_angle))
        weighted = (jacobian * weight[:, None]).T

        damping = np.diag([1e-3, 1e-3, 1e-5])
        step = np.linalg.solve(weighted @ jacobian + damping, weighted @ distance)
        largest = np.array([0.03, 0.03, 0.3])  # m, m, rad
        bounded: Array = np.clip(step, -largest, largest)
        return bounded

    def score(self, pose: Array, image: RGBDImage, face: TopFace) -> float:
        """The least of three shares: edges on the outline, surface inside it, its inside seen."""
        corners = self.placed(pose)
        distance, _ = signed_distance(face.edges, corners)
        on_outline = float((np.abs(distance) < FIT_TOLERANCE).mean())

        surface = thin(face.surface, 200)
        inside = float(contains(surface, corners, FIT_TOLERANCE).mean())
        return min(on_outline, inside, self._visible_share(pose, image, face))

    def _visible_share(self, pose: Array, image: RGBDImage, face: TopFace) -> float:
        """Share of the samples of the surface at a pose that are seen where nothing hides them."""
        samples = place(self.samples, pose)
        points = np.column_stack((samples, np.full(len(samples), face.height)))
        x, y, z = ((points - image.position) @ image.rotation).T

        focal, center_x, center_y, width, height = self.intrinsics
        u, v = focal * x / z + center_x, focal * y / z + center_y
        in_view = (u > 1) & (u < width - 2) & (v > 1) & (v < height - 2)
        columns, rows = u[in_view].round().astype(int), v[in_view].round().astype(int)

        free = ~face.hidden[rows, columns]
        seen = is_colored(image.rgb[rows[free], columns[free]])
        return float(seen.mean()) if len(seen) >= 5 else 0.0

    @cached_property
    def samples(self) -> Array:
        """Points well inside the outline, ``(n, 2)``, m."""
        low, high = self.corners.min(0), self.corners.max(0)
        columns = np.arange(low[0], high[0], SAMPLE_SPACING)
        rows = np.arange(low[1], high[1], SAMPLE_SPACING)
        x, y = np.meshgrid(columns, rows)

        grid = np.column_stack((x.ravel(), y.ravel()))
        kept: Array = grid[contains(grid, self.corners, -SAMPLE_INSET)]
        return kept

    def placed(self, pose: Array) -> Array:
        """The corners at a pose (x, y, θ) ``(3,)``, ``(N, 2)``, m."""
        return place(self.corners, pose)
