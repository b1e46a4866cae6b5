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
from aicon_envs.pusht.simulation import SIZE, Simulation

os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
try:
    with warnings.catch_warnings():
        # pygame still imports it.
        warnings.filterwarnings("ignore", "pkg_resources is deprecated")
        import cv2
        import pygame
        from pymunk.pygame_util import DrawOptions, to_pygame
except ImportError as error:
    raise DependencyNotInstalled(
        'pictures of pushT need pygame and OpenCV: pip install "aicon-torch[pusht]"'
    ) from error

Picture = NDArray[np.uint8]

_BACKGROUND = (255, 255, 255)
_GOAL = (144, 238, 144)
_TARGET = (255, 0, 0)

_LIGHTER = 1.2
"""Fills are brighter than their outlines by this factor."""


def draw_observation(simulation: Simulation, goal: Goal, size: tuple[int, int]) -> Picture:
    """Return the picture of an observation, (height, width, 3), for `size` (width, height)."""
    surface = _draw_world(simulation, goal)
    side = surface.get_width()
    content = pygame.image.tobytes(surface, "RGB")
    pixels = np.frombuffer(content, np.uint8).reshape(side, side, 3)
    return np.asarray(cv2.resize(pixels, size), np.uint8)


def draw_view(
    simulation: Simulation, goal: Goal, size: tuple[int, int], target: Point | None
) -> Picture:
    """Return the picture for people, (height, width, 3), with a cross at the pusher's target.

    Args:
        simulation: The world.
        goal: The goal to show.
        size: Width and height, pixels.
        target: Where the pusher is going, px of the world.
    """
    picture = draw_observation(simulation, goal, size)
    if target is None:
        return picture

    # A pixel of the smallest usual picture is the unit of the cross.
    unit = min(size) / 96.0
    reach, width = round(4.0 * unit), max(1, round(unit))
    x, y = (round(place * side / SIZE) for place, side in zip(target, size, strict=True))

    surface = pygame.surfarray.make_surface(picture.transpose(1, 0, 2))
    pygame.draw.line(surface, _TARGET, (x - reach, y), (x + reach, y), width)
    pygame.draw.line(surface, _TARGET, (x, y - reach), (x, y + reach), width)
    return np.ascontiguousarray(pygame.surfarray.array3d(surface).transpose(1, 0, 2))


class _ShapePainter(DrawOptions):
    """Paints pymunk's shapes.

    The pusher has a lighter disc within, a polygon is lighter than its border of 2 px.
    """

    def draw_circle(
        self,
        pos: Vec2d,
        angle: float,
        radius: float,
        outline_color: SpaceDebugColor,
        fill_color: SpaceDebugColor,
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
        """Draw a part of the object."""
        corners = [to_pygame(vertex, self.surface) for vertex in verts]
        pygame.draw.polygon(self.surface, _lighter(fill_color), corners)

        for start, end in zip(verts, [*verts[1:], verts[0]], strict=True):
            self.draw_fat_segment(start, end, 2, fill_color, fill_color)


def _draw_world(simulation: Simulation, goal: Goal) -> pygame.Surface:
    surface = pygame.Surface((round(SIZE), round(SIZE)))
    surface.fill(_BACKGROUND)

    for part in goal.parts:
        corners = [(round(x), round(y)) for x, y in part]
        pygame.draw.polygon(surface, _GOAL, corners)

    simulation.space.debug_draw(_ShapePainter(surface))
    return surface


def _lighter(color: SpaceDebugColor) -> tuple[int, ...]:
    return tuple(round(min(_LIGHTER * channel, 255.0)) for channel in color)
