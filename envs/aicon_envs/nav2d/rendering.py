"""Headless pictures of a navigation world, drawn with Pillow."""

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from aicon_envs.arrays import FloatArray
from aicon_envs.nav2d.simulation import ARRIVAL_DISTANCE
from aicon_envs.nav2d.world import NavigationMap, Point

Color = tuple[int, int, int]

_BACKGROUND = (250, 249, 246)
_OBSTACLE = (64, 70, 82)
_TARGET = (46, 139, 87)
_START = (176, 176, 176)
_TRAIL = (120, 165, 214)
_AGENT = (31, 96, 176)

_TARGET_RINGS = ((1.0, _TARGET), (0.75, _BACKGROUND), (0.4, _TARGET))
"""Discs that make up the target, largest first: share of the arrival distance, and color."""

_TRAIL_WIDTH = 0.04
"""Width of the line along which the agent has come, m."""

_MARGIN = 0.6
"""Free space around the world's extent, m."""

_OVERSAMPLING = 3
"""Pictures are drawn this many times larger and then reduced, which smooths the edges."""


class Scene:
    """A world, the agent in it, and where it has been.

    Args:
        world: The map to show.
        radius: Radius of the agent, m.
        size: Width and height of the picture, pixels.
    """

    def __init__(self, world: NavigationMap, radius: float, size: int = 480) -> None:
        """Fit the view to the world."""
        low, high = _extent(world)
        self._size = size
        # Pixels of the enlarged picture per metre: the longer side of the extent fills it.
        self._scale = size * _OVERSAMPLING / float((high - low).max())
        self._center = (low + high) / 2.0
        self._radius = radius

        self._trail = [self._pixel(world.start)]
        self._backdrop = self._draw_world(world)

    def move(self, position: FloatArray) -> None:
        """Put the agent at `position` (x, y), m, and extend its trail."""
        self._trail.append(self._pixel((float(position[0]), float(position[1]))))

    def draw(self) -> NDArray[np.uint8]:
        """Return the picture, (size, size, 3)."""
        image = self._backdrop.copy()
        draw = ImageDraw.Draw(image)

        width = max(1, round(_TRAIL_WIDTH * self._scale))
        draw.line(self._trail, fill=_TRAIL, width=width, joint="curve")
        self._disc(draw, self._trail[-1], self._radius, _AGENT)

        reduced = image.resize((self._size, self._size), Image.Resampling.BOX)
        return np.array(reduced)

    def _draw_world(self, world: NavigationMap) -> Image.Image:
        """Draw what does not move: obstacles, start and target."""
        width = self._size * _OVERSAMPLING
        image = Image.new("RGB", (width, width), _BACKGROUND)
        draw = ImageDraw.Draw(image)

        for polygon in world.obstacles:
            draw.polygon([self._pixel(vertex) for vertex in polygon], fill=_OBSTACLE)

        self._disc(draw, self._pixel(world.start), self._radius, _START)

        for share, color in _TARGET_RINGS:
            self._disc(draw, self._pixel(world.target), share * ARRIVAL_DISTANCE, color)

        return image

    def _disc(self, draw: ImageDraw.ImageDraw, center: Point, radius: float, color: Color) -> None:
        """Draw a disc around a pixel, with a radius in metres."""
        x, y = center
        extent = radius * self._scale
        draw.ellipse((x - extent, y - extent, x + extent, y + extent), fill=color)

    def _pixel(self, point: Point) -> Point:
        """Map metres to pixels of the enlarged picture; y points up in the world, down in it."""
        x, y = (np.asarray(point) - self._center) * self._scale
        middle = self._size * _OVERSAMPLING / 2.0
        return middle + float(x), middle - float(y)


def _extent(world: NavigationMap) -> tuple[FloatArray, FloatArray]:
    """Return the lower and upper corner (x, y) of what a picture shows, m."""
    points = [world.start, world.target]
    for polygon in world.obstacles:
        points += polygon

    low = np.min(points, axis=0) - _MARGIN
    high = np.max(points, axis=0) + _MARGIN
    return low, high
