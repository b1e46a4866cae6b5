"""Where an object of known outline is in an image: registration of the edges of its top face.

Dense numpy, one image at a time. What a graph reads are the corners that come out.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from aicon_torch.models.arm_push.image_segmentation import (
    RGBDImage,
    TopFace,
    TopFaceSegmentation,
    is_colored,
    thin,
)
from aicon_torch.models.arm_push.polygon import Array, contains, place, signed_distance
from aicon_torch.parts.camera import Intrinsics

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

LARGEST_STEP = np.array([0.03, 0.03, 0.3])
"""Of Gauss-Newton, m, m and rad."""

SMALLEST_STEP = 1e-5
"""A fit ends with a step that is smaller, m and rad."""

TRUSTED_SCORE = 0.85
"""Score from which a registration that starts at the prior is taken as it is."""

ORIENTATIONS = 16
"""How many a search tries: a fit finds the outline from a start a sixteenth of a turn off."""

MOST_STEPS = 10
"""Of Gauss-Newton: a fit from nearby ends after four or five."""

FEWEST_SAMPLES = 5
"""Of the surface, without which it does not count as seen."""


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
    """

    corners: Array
    intrinsics: Intrinsics

    def __call__(self, image: RGBDImage, prior: Array | None) -> Detection | None:
        """Find the object.

        Args:
            image: The image.
            prior: Its expected pose (x, y, θ) ``(3,)``, m and rad; None if nothing is known.

        Returns:
            What the image shows; None if it shows too little of the object.
        """
        face = TopFaceSegmentation(self.intrinsics)(image)
        if face is None:
            return None

        expected = None if prior is None else self.detect(prior, image, face)
        if expected is not None and expected.score >= TRUSTED_SCORE:
            return expected
        return self.search(image, face, expected)

    def search(self, image: RGBDImage, face: TopFace, best: Detection | None) -> Detection:
        """The best fit from starts in all orientations at once, or from the best so far."""
        # Few points for many starts; the best of them is then fitted to all.
        coarse = face._replace(edges=thin(face.edges, SEARCH_EDGE_POINTS))
        angles = np.arange(ORIENTATIONS) * 2 * np.pi / ORIENTATIONS
        middles = np.tile(face.surface.mean(0), (ORIENTATIONS, 1))

        poses = self.fit(np.column_stack((middles, angles)), coarse.edges)
        scores = self.score(poses, image, coarse)
        if best is None or scores.max() > best.score:
            return self.detect(poses[scores.argmax()], image, face)
        return self.detect(best.pose, image, face)

    def detect(self, start: Array, image: RGBDImage, face: TopFace) -> Detection:
        """What is found from one start ``(3,)``."""
        pose = self.fit(start, face.edges)
        score = float(self.score(pose, image, face))
        return Detection(pose, face.height, score, face.surface.mean(0))

    def fit(self, starts: Array, edges: Array) -> Array:
        """Gauss-Newton on the distance of edge points to the nearest side of the outline.

        Args:
            starts: Poses (x, y, θ) ``(*B, 3)`` to start from, m and rad.
            edges: Edge points ``(k, 2)``, m.

        Returns:
            The poses that fit, ``(*B, 3)``.
        """
        poses = np.array(starts, dtype=np.float64)

        # A fit that has arrived stands still while others go on.
        moving = np.ones((*poses.shape[:-1], 1), np.bool_)
        for iteration in range(MOST_STEPS):
            scale = FIRST_SCALE if iteration < MOST_STEPS // 2 else LAST_SCALE
            steps = moving * self._gauss_newton_steps(poses, edges, scale)
            poses += steps

            moving &= np.abs(steps).max(-1, keepdims=True) >= SMALLEST_STEP
            if not moving.any():
                break
        return poses

    def _gauss_newton_steps(self, poses: Array, edges: Array, scale: float) -> Array:
        """The changes of poses, ``(*B, 3)``, that fit the edges best, with Cauchy weights."""
        distance, normal = signed_distance(edges, self.placed(poses))
        weight = 1.0 / (1.0 + (distance / (0.3 * scale)) ** 2)

        # A point moves with the outline by (dx, dy) and by dθ × its arm.
        arm_x = edges[:, 0] - poses[..., :1]
        arm_y = edges[:, 1] - poses[..., 1:2]
        by_angle = arm_x * normal[..., 1] - arm_y * normal[..., 0]
        jacobian = np.concatenate((normal, by_angle[..., None]), axis=-1)
        weighted = np.swapaxes(jacobian * weight[..., None], -1, -2)

        # Damped a little: edges that all run in one direction leave the pose open along it.
        damped = weighted @ jacobian + np.diag([1e-3, 1e-3, 1e-5])
        steps = np.linalg.solve(damped, weighted @ distance[..., None])[..., 0]
        return np.clip(steps, -LARGEST_STEP, LARGEST_STEP)

    def score(self, poses: Array, image: RGBDImage, face: TopFace) -> Array:
        """The least of three shares: edges on the outline, surface inside it, its inside seen.

        Args:
            poses: Poses (x, y, θ) ``(*B, 3)``, m and rad.
            image: The image.
            face: What it shows of the object.

        Returns:
            ``(*B,)``.
        """
        corners = self.placed(poses)
        distance, _ = signed_distance(face.edges, corners)
        on_outline = (np.abs(distance) < FIT_TOLERANCE).mean(-1)

        surface = thin(face.surface, 200)
        inside = contains(surface, corners, FIT_TOLERANCE).mean(-1)
        least: Array = np.minimum(on_outline, inside)
        return np.minimum(least, self._visible_share(poses, image, face))

    def _visible_share(self, poses: Array, image: RGBDImage, face: TopFace) -> Array:
        """Share of the samples of the surface at poses that are seen where nothing hides them."""
        samples = place(self.samples, poses)
        heights = np.full((*samples.shape[:-1], 1), face.height)
        points = np.concatenate((samples, heights), axis=-1)

        # As the camera sees the samples: z ahead, and u and v in px.
        x, y, z = np.moveaxis((points - image.position) @ image.rotation, -1, 0)

        focal, center_x, center_y, width, height = self.intrinsics
        u, v = focal * x / z + center_x, focal * y / z + center_y
        in_view = (u > 1) & (u < width - 2) & (v > 1) & (v < height - 2)
        columns = np.where(in_view, u, 0.0).round().astype(int)
        rows = np.where(in_view, v, 0.0).round().astype(int)

        # A sample that something hides tells nothing, either way.
        free = in_view & ~face.hidden[rows, columns]
        seen = free & is_colored(image.rgb[rows, columns])
        count = free.sum(-1)
        return np.where(count >= FEWEST_SAMPLES, seen.sum(-1) / count.clip(min=1), 0.0)

    @cached_property
    def samples(self) -> Array:
        """Points well inside the outline, ``(n, 2)``, m."""
        low, high = self.corners.min(0), self.corners.max(0)
        columns = np.arange(low[0], high[0], SAMPLE_SPACING)
        rows = np.arange(low[1], high[1], SAMPLE_SPACING)
        x, y = np.meshgrid(columns, rows)

        grid = np.column_stack((x.ravel(), y.ravel()))
        return grid[contains(grid, self.corners, -SAMPLE_INSET)]

    def placed(self, poses: Array) -> Array:
        """The corners at poses (x, y, θ) ``(*B, 3)``, ``(*B, N, 2)``, m."""
        return place(self.corners, poses)
