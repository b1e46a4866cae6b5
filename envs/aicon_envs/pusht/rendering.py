"""Headless pictures of the pushT world, drawn with pygame as gym-pusht draws them."""

import os
import warnings
from collections.abc import Sequence

import numpy as np
from gymnasium.error import DependencyNotInstalled
from numpy.typing import NDArray
from pymunk import Vec2d
from pymunk.space_debug_draw_options import SpaceDebugColor

from aicon_envs.pusht.geometry import Point
from aicon_envs.pusht.goal import Goal
from aicon_envs.pusht.overlay import Overlay
from aicon_envs.pusht.simulation import SIZE, Simulation

os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
try:
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "pkg_resources is deprecated")  # pygame still imports it
        import pygame
        from pymunk.pygame_util import DrawOptions, to_pygame
except ImportError as error:
    raise DependencyNotInstalled('pictures of pushT need pygame: pip install "aicon-torch[pusht]"') from error

Picture = NDArray[np.uint8]

_BACKGROUND = (255, 255, 255)
_GOAL = (144, 238, 144)
_TARGET = (255, 0, 0)
_TEXT = (40, 40, 40)

_LIGHTER = 1.2
"""Fills are brighter than their outlines by this factor."""


def draw_observation(simulation: Simulation, goal: Goal, size: tuple[int, int]) -> Picture:
    """Return the picture of an observation, (height, width, 3), for `size` (width, height)."""
    surface = _draw_world(simulation, goal)
    return resize(pygame.surfarray.pixels3d(surface).transpose(1, 0, 2), *size)


def draw_view(
    simulation: Simulation, goal: Goal, size: tuple[int, int], target: Point | None, overlay: Overlay | None
) -> Picture:
    """Return the picture for people, (height, width, 3), with the pusher's target and an overlay.

    Args:
        simulation: The world.
        goal: The goal to show.
        size: Width and height, pixels.
        target: Where the pusher is going, px of the world.
        overlay: What to draw on top.
    """
    picture = draw_observation(simulation, goal, size)
    surface = pygame.surfarray.make_surface(picture.transpose(1, 0, 2))
    canvas = _Canvas(surface, size)
    if target is not None:
        canvas.cross(target)
    if overlay is not None:
        canvas.draw(overlay)
    return np.ascontiguousarray(pygame.surfarray.array3d(surface).transpose(1, 0, 2))


def resize(picture: Picture, width: int, height: int) -> Picture:
    """Resize bilinearly, in the fixed-point arithmetic of OpenCV's `INTER_LINEAR`: pictures equal gym-pusht's.

    Weights are multiples of 1/2048. A row's blend loses 4 bits, its product with the row's weight 16, and the last 2
    are rounded.
    """
    left, right, weight_left, weight_right = _bilinear(picture.shape[1], width)
    top, bottom, weight_top, weight_bottom = _bilinear(picture.shape[0], height)

    def blend(rows: NDArray[np.int64], weight: NDArray[np.int32]) -> NDArray[np.int32]:
        row = picture[np.ix_(rows, left)] * weight_left[:, np.newaxis]
        row += picture[np.ix_(rows, right)] * weight_right[:, np.newaxis]
        return ((row >> 4) * weight[:, np.newaxis, np.newaxis]) >> 16

    resized: Picture = ((blend(top, weight_top) + blend(bottom, weight_bottom) + 2) >> 2).astype(np.uint8)
    return resized


class _Canvas:
    """A picture of the world to draw on, in px of the world."""

    def __init__(self, surface: pygame.Surface, size: tuple[int, int]) -> None:
        self._surface = surface
        self._scale = size[0] / SIZE, size[1] / SIZE
        self._unit = min(size) / 96.0

    def cross(self, point: Point) -> None:
        x, y = self._pixel(point)
        reach, width = round(4.0 * self._unit), max(1, round(self._unit))
        pygame.draw.line(self._surface, _TARGET, (x - reach, y), (x + reach, y), width)
        pygame.draw.line(self._surface, _TARGET, (x, y - reach), (x, y + reach), width)

    def draw(self, overlay: Overlay) -> None:
        for x, y, dx, dy, color in overlay.arrows:
            self._arrow((x, y), (dx, dy), color)
        for x, y, color in overlay.points:
            pygame.draw.circle(self._surface, color, self._pixel((x, y)), max(2, round(0.7 * self._unit)))
        if overlay.text:
            pygame.font.init()
            font = pygame.font.Font(None, max(10, round(4.0 * self._unit)))
            self._surface.blit(font.render(overlay.text, True, _TEXT), (round(2 * self._unit), round(2 * self._unit)))

    def _arrow(self, start: Point, offset: Point, color: Sequence[int]) -> None:
        (x, y), (dx, dy) = start, offset
        tip = self._pixel((x + dx, y + dy))
        width = max(1, round(0.5 * self._unit))
        pygame.draw.line(self._surface, tuple(color), self._pixel(start), tip, width)
        for side in (-1.0, 1.0):
            barb = x + 0.75 * dx - side * 0.12 * dy, y + 0.75 * dy + side * 0.12 * dx
            pygame.draw.line(self._surface, tuple(color), self._pixel(barb), tip, width)

    def _pixel(self, point: Point) -> tuple[int, int]:
        return round(point[0] * self._scale[0]), round(point[1] * self._scale[1])


class _Painter(DrawOptions):
    """Paints pymunk's shapes: a lighter disc within the pusher, a border of 2 px around a lighter polygon."""

    def draw_circle(
        self, pos: Vec2d, angle: float, radius: float, outline_color: SpaceDebugColor, fill_color: SpaceDebugColor
    ) -> None:
        """Draw the pusher."""
        center = to_pygame(pos, self.surface)
        pygame.draw.circle(self.surface, fill_color.as_int(), center, round(radius))
        pygame.draw.circle(self.surface, _lighter(fill_color), center, round(radius - 4))

    def draw_polygon(
        self,
        verts: Sequence[tuple[float, float]],
        radius: float,
        outline_color: SpaceDebugColor,
        fill_color: SpaceDebugColor,
    ) -> None:
        """Draw a part of the block."""
        corners = [to_pygame(vertex, self.surface) for vertex in verts]
        pygame.draw.polygon(self.surface, _lighter(fill_color), corners)
        for start, end in zip(verts, [*verts[1:], verts[0]], strict=True):
            self.draw_fat_segment(start, end, 2, fill_color, fill_color)


def _draw_world(simulation: Simulation, goal: Goal) -> pygame.Surface:
    surface = pygame.Surface((round(SIZE), round(SIZE)))
    surface.fill(_BACKGROUND)
    for part in goal.parts:
        pygame.draw.polygon(surface, _GOAL, [(round(x), round(y)) for x, y in part])
    simulation.space.debug_draw(_Painter(surface))
    return surface


def _lighter(color: SpaceDebugColor) -> tuple[int, ...]:
    return tuple(round(min(_LIGHTER * channel, 255.0)) for channel in color)


def _bilinear(
    source: int, count: int
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int32], NDArray[np.int32]]:
    """Return, for each of `count` pixels, the two of `source` pixels it lies between and their weights in 1/2048."""
    position = ((np.arange(count) + 0.5) * (source / count) - 0.5).astype(np.float32)
    position = np.clip(position, 0.0, source - 1.0)
    low = np.floor(position).astype(np.int64)
    share = position - low.astype(np.float32)
    weights = (np.rint(each * np.float32(2048.0)).astype(np.int32) for each in (1.0 - share, share))
    return low, np.minimum(low + 1, source - 1), *weights
