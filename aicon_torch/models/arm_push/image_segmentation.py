"""What a camera shows of a coloured object: its top face, the edges of it, and what hides them.

Dense numpy, one image at a time.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from aicon_torch.models.arm_push.polygon import Array, Mask
from aicon_torch.parts.camera import Intrinsics

DARKEST_COLOR = 60
"""Value of a pixel, of 255, below which it has no colour."""

FACE_THICKNESS = 0.012
"""Points of the top face are measured within this of its height, m."""

FEWEST_EDGE_POINTS = 12
"""Without which a face does not count as seen; on its surface there must be twice as many."""

MOST_EDGE_POINTS = 150


class RGBDImage(NamedTuple):
    """An image from a known place.

    Attributes:
        rgb: ``(H, W, 3)``, 0 to 255.
        depth: ``(H, W)``, along the optical axis, m.
        rotation: Of the camera, ``(3, 3)``: columns are right, down and forward.
        position: Of the camera, ``(3,)``, m.
    """

    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32]
    rotation: Array
    position: Array


class TopFace(NamedTuple):
    """The top face of an object, as far as it is seen.

    Attributes:
        surface: Points on it, ``(n, 2)``, m.
        edges: Points on its edges, ``(k, 2)``, m.
        height: m.
        hidden: Pixels in which something else is in front, ``(H, W)``.
    """

    surface: Array
    edges: Array
    height: float
    hidden: Mask


@dataclass(frozen=True)
class TopFaceSegmentation:
    """Finds the top face of an object that is red or blue, behind a black tool.

    Attributes:
        intrinsics: Of the camera.
    """

    intrinsics: Intrinsics

    def __call__(self, image: RGBDImage) -> TopFace | None:
        """The top face; None if the image shows too little of it."""
        brightness = _planes(image.rgb).max(axis=0)  # the largest of the three colours
        colored = is_colored(image.rgb) & (brightness > DARKEST_COLOR)
        if colored.sum() < FEWEST_EDGE_POINTS:
            return None

        # The top is where most of the object is, by its depth and its brightness.
        height, face = self._face(image, colored, brightness)
        rows, columns = np.nonzero(face)
        if len(rows) < FEWEST_EDGE_POINTS:
            return None

        hidden = brightness < DARKEST_COLOR
        surface = self._on_plane(columns, rows, image, height)
        edges = self._edges(image, face, hidden, height)
        if len(edges) < FEWEST_EDGE_POINTS or len(surface) < 2 * FEWEST_EDGE_POINTS:
            return None
        return TopFace(surface, edges, height, hidden)

    def _face(
        self, image: RGBDImage, colored: Mask, brightness: NDArray[np.uint8]
    ) -> tuple[float, Mask]:
        """Height of the top face, m, and its pixels ``(H, W)``."""
        rows, columns = np.nonzero(colored)
        rays = self._rays(columns, rows) * image.depth[rows, columns]
        heights = image.rotation[2] @ rays + image.position[2]

        # The sides are lower than the top face: without them, the median is on it.
        upper = heights[heights > np.quantile(heights, 0.3)]
        top = float(np.median(upper if len(upper) else heights))

        # The sides of the object are lower, or in the shade.
        brightness = brightness[rows, columns]
        bright = brightness > 0.75 * np.median(brightness)
        flat = (np.abs(heights - top) < FACE_THICKNESS) & bright

        face = np.zeros(colored.shape, np.bool_)
        face[rows[flat], columns[flat]] = True
        return top, close(face) & colored

    def _edges(self, image: RGBDImage, face: Mask, hidden: Mask, height: float) -> Array:
        """Points on the edges of a face, halfway to a neighbour that is neither face nor hidden."""
        rows, columns = np.nonzero(face)
        image_height, image_width = face.shape
        blocked = dilate(hidden)
        points = []

        for right, down in ((1, 0), (-1, 0), (0, 1), (0, -1)):
            # Neighbours within the picture, ...
            next_column, next_row = columns + right, rows + down
            inside = (next_column >= 0) & (next_column < image_width)
            inside &= (next_row >= 0) & (next_row < image_height)

            # ... that are of something else, and not of what hides the face.
            neighbours = next_row[inside], next_column[inside]
            edge = ~face[neighbours] & ~blocked[neighbours]
            u = columns[inside][edge] + 0.5 * right
            v = rows[inside][edge] + 0.5 * down
            points.append(self._on_plane(u, v, image, height))

        edges = np.concatenate(points)
        return thin(edges, MOST_EDGE_POINTS)

    def _on_plane(self, u: NDArray[Any], v: NDArray[Any], image: RGBDImage, height: float) -> Array:
        """Where the rays through pixels meet the plane of a height, ``(n, 2)``, m."""
        rays = image.rotation @ self._rays(u, v)

        # Along each ray from the camera, until it has dropped to the height.
        drop = height - image.position[2]
        points: Array = (image.position[:2, None] + rays[:2] * drop / rays[2]).T
        return points

    def _rays(self, u: NDArray[Any], v: NDArray[Any]) -> Array:
        """The rays through pixels in the frame of the camera, at a depth of one, ``(3, n)``."""
        focal, center_x, center_y, _, _ = self.intrinsics
        return np.stack(((u - center_x) / focal, (v - center_y) / focal, np.ones(len(u))))


def is_colored(rgb: NDArray[np.uint8]) -> Mask:
    """Whether pixels ``(..., 3)`` are red, or blue, however dark."""
    # By half more than either of the others; in 16 bits, since three times 255 exceeds a byte.
    red, green, blue = _planes(rgb.astype(np.int16))
    is_red = 2 * red > 3 * np.maximum(green, blue)
    is_blue = 2 * blue > 3 * np.maximum(red, green)
    colored: Mask = is_red | is_blue
    return colored


def thin(points: Array, most: int) -> Array:
    """Every k-th of the points, so that about as many remain as are asked for at most."""
    return points[:: max(1, len(points) // most)]


def dilate(mask: Mask) -> Mask:
    """A mask ``(H, W)`` with its neighbours above, below, left and right."""
    grown = mask.copy()
    grown[1:] |= mask[:-1]
    grown[:-1] |= mask[1:]
    grown[:, 1:] |= mask[:, :-1]
    grown[:, :-1] |= mask[:, 1:]
    return grown


def close(mask: Mask) -> Mask:
    """A mask ``(H, W)`` without its holes of one pixel."""
    return ~dilate(~dilate(mask))


def _planes(rgb: NDArray[Any]) -> NDArray[Any]:
    """The three colours of pixels ``(..., 3)``, each contiguous, ``(3, ...)``."""
    return np.ascontiguousarray(np.moveaxis(rgb, -1, 0))
