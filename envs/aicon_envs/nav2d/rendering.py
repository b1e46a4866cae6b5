"""Headless pictures of a navigation world, drawn with Pillow."""

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from aicon_envs.nav2d.simulation import ARRIVAL_DISTANCE
from aicon_envs.nav2d.world import NavigationMap, Point

_BACKGROUND = (250, 249, 246)
_OBSTACLE = (64, 70, 82)
_TARGET = (46, 139, 87)
_START = (176, 176, 176)
_TRAIL = (120, 165, 214)
_AGENT = (31, 96, 176)

_MARGIN = 0.6
"""Free space around the world's extent, m."""

_OVERSAMPLING = 3
"""Pictures are drawn this many times larger and then reduced, which smooths the edges."""


class Scene:
    """A world, the agent in it, and where it has been."""

    def __init__(self, world: NavigationMap, radius: float, size: int = 480) -> None:
        """Fit the view to the world.

        Args:
            world: The map to show.
            radius: Radius of the agent, m.
            size: Width and height of the picture, pixels.
        """
        points = np.array([world.start, world.target, *(vertex for polygon in world.obstacles for vertex in polygon)])
        low, high = points.min(axis=0) - _MARGIN, points.max(axis=0) + _MARGIN
        self._size = size
        self._scale = size * _OVERSAMPLING / float((high - low).max())
        self._center = (low + high) / 2.0
        self._radius = radius
        self._trail = [self._pixel(world.start)]
        self._backdrop = self._draw_world(world)

    def move(self, position: NDArray[np.float64]) -> None:
        """Put the agent at `position` (x, y), m, and extend its trail."""
        self._trail.append(self._pixel((float(position[0]), float(position[1]))))

    def draw(self) -> NDArray[np.uint8]:
        """Return the picture, (size, size, 3)."""
        image = self._backdrop.copy()
        draw = ImageDraw.Draw(image)
        draw.line(self._trail, fill=_TRAIL, width=max(1, round(0.04 * self._scale)), joint="curve")
        self._disc(draw, self._trail[-1], self._radius, _AGENT)
        return np.asarray(image.resize((self._size, self._size), Image.Resampling.BOX))

    def _draw_world(self, world: NavigationMap) -> Image.Image:
        width = self._size * _OVERSAMPLING
        image = Image.new("RGB", (width, width), _BACKGROUND)
        draw = ImageDraw.Draw(image)
        for polygon in world.obstacles:
            draw.polygon([self._pixel(vertex) for vertex in polygon], fill=_OBSTACLE)
        self._disc(draw, self._pixel(world.start), self._radius, _START)
        target = self._pixel(world.target)
        for share, color in ((1.0, _TARGET), (0.75, _BACKGROUND), (0.4, _TARGET)):
            self._disc(draw, target, share * ARRIVAL_DISTANCE, color)
        return image

    def _disc(self, draw: ImageDraw.ImageDraw, center: Point, radius: float, color: tuple[int, int, int]) -> None:
        extent = radius * self._scale
        draw.ellipse((center[0] - extent, center[1] - extent, center[0] + extent, center[1] + extent), fill=color)

    def _pixel(self, point: Point) -> Point:
        """Map metres to pixels of the enlarged picture; y points up in the world, down in the picture."""
        x, y = (np.asarray(point) - self._center) * self._scale
        middle = self._size * _OVERSAMPLING / 2.0
        return middle + float(x), middle - float(y)
