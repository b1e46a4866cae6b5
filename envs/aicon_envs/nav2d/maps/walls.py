"""Maps with one bent wall between start and target."""

import numpy as np

from aicon_envs.nav2d.maps.layout import Layout, LayoutGenerator, draw_thickness, wall
from aicon_envs.nav2d.world import Point


def u_trap(depth: float) -> LayoutGenerator:
    """Return the generator of U traps: arms of `depth` metres from the back wall to the start."""

    def generate(rng: np.random.Generator) -> Layout:
        # The back wall lies on the y axis, the arms point to negative x.
        low = -rng.uniform(0.8, 1.3)
        high = rng.uniform(0.8, 1.3)
        lower_arm, upper_arm = depth * rng.uniform(0.97, 1.03, size=2)
        corners = [(-lower_arm, low), (0.0, low), (0.0, high), (-upper_arm, high)]
        trap = wall(corners, draw_thickness(rng))

        # At least 4.2 m from start to target.
        start = (-depth - rng.uniform(1.0, 2.0), rng.uniform(-0.3, 0.3))
        target_x = max(rng.uniform(1.5, 3.0), 4.2 + start[0])
        target_y = rng.uniform(-0.3, 0.3)
        return Layout(trap, start, (target_x, target_y))

    return generate


def l_shape(rng: np.random.Generator) -> Layout:
    """An L: a wall across the way with one arm back along it."""
    arm = rng.uniform(1.2, 2.5)
    short = rng.uniform(0.4, 1.0)
    long = rng.uniform(1.2, 2.4)
    solid = wall([(-arm, -short), (0.0, -short), (0.0, long)], draw_thickness(rng))

    start = _draw_start(rng, arm)
    target = _draw_target(rng)
    return Layout(solid, start, target)


def zigzag(rng: np.random.Generator) -> Layout:
    """A folded wall across the way."""
    folds = int(rng.integers(4, 8))

    # Corners evenly up the y axis, a little off...
    y = np.linspace(-0.5, 0.5, folds) * rng.uniform(3.5, 6.0)
    y += rng.uniform(-0.15, 0.15, size=folds)

    # ... and in turn left and right of it.
    alternating = rng.choice((-1.0, 1.0)) * (-1.0) ** np.arange(folds)
    x = alternating * rng.uniform(0.35, 0.7, size=folds)
    solid = wall(np.column_stack([x, y]), draw_thickness(rng))

    start = _draw_start(rng, extent=0.7)
    target = _draw_target(rng, extent=0.7)
    return Layout(solid, start, target)


def long_wall(rng: np.random.Generator) -> Layout:
    """A long straight wall across the way, longer on one side."""
    length = rng.uniform(4.0, 8.0)
    middle = rng.uniform(-0.8, 0.8)
    slant = rng.uniform(-0.4, 0.4)
    ends = [(-slant, middle - length / 2.0), (slant, middle + length / 2.0)]
    solid = wall(ends, draw_thickness(rng))

    start = _draw_start(rng, extent=0.4)
    target = _draw_target(rng, extent=0.4)
    return Layout(solid, start, target)


def _draw_start(rng: np.random.Generator, extent: float) -> Point:
    """Draw a start before a wall that reaches `extent` metres towards it."""
    return -extent - rng.uniform(1.5, 3.0), rng.uniform(-0.3, 0.3)


def _draw_target(rng: np.random.Generator, extent: float = 0.0) -> Point:
    """Draw a target behind a wall that reaches `extent` metres towards it."""
    return extent + rng.uniform(1.5, 3.0), rng.uniform(-0.3, 0.3)
