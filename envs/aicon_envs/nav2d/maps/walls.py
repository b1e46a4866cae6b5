"""Maps with one bent wall between start and target."""

import numpy as np

from aicon_envs.nav2d.maps.sketch import Generator, Sketch, draw_thickness, wall
from aicon_envs.nav2d.world import Point


def u_trap(depth: float) -> Generator:
    """Return the generator of U traps whose arms reach `depth` metres from the back wall towards the start."""

    def generate(rng: np.random.Generator) -> Sketch:
        low, high = -rng.uniform(0.8, 1.3), rng.uniform(0.8, 1.3)
        arms = depth * rng.uniform(0.97, 1.03, size=2)
        solid = wall([(-arms[0], low), (0.0, low), (0.0, high), (-arms[1], high)], draw_thickness(rng))
        start = (-depth - rng.uniform(1.0, 2.0), rng.uniform(-0.3, 0.3))
        return Sketch(solid, start, (max(rng.uniform(1.5, 3.0), 4.2 + start[0]), rng.uniform(-0.3, 0.3)))

    return generate


def l_shape(rng: np.random.Generator) -> Sketch:
    """An L: a wall across the way with one arm back along it."""
    arm, short, long = rng.uniform(1.2, 2.5), rng.uniform(0.4, 1.0), rng.uniform(1.2, 2.4)
    solid = wall([(-arm, -short), (0.0, -short), (0.0, long)], draw_thickness(rng))
    return Sketch(solid, _before(rng, arm), _behind(rng))


def zigzag(rng: np.random.Generator) -> Sketch:
    """A folded wall across the way."""
    folds = int(rng.integers(4, 8))
    y = np.linspace(-0.5, 0.5, folds) * rng.uniform(3.5, 6.0) + rng.uniform(-0.15, 0.15, size=folds)
    x = rng.choice((-1.0, 1.0)) * (-1.0) ** np.arange(folds) * rng.uniform(0.35, 0.7, size=folds)
    return Sketch(wall(np.column_stack([x, y]), draw_thickness(rng)), _before(rng, 0.7), _behind(rng, 0.7))


def long_wall(rng: np.random.Generator) -> Sketch:
    """A long straight wall across the way, longer on one side."""
    length, middle, slant = rng.uniform(4.0, 8.0), rng.uniform(-0.8, 0.8), rng.uniform(-0.4, 0.4)
    ends = [(-slant, middle - length / 2.0), (slant, middle + length / 2.0)]
    return Sketch(wall(ends, draw_thickness(rng)), _before(rng, 0.4), _behind(rng, 0.4))


def _before(rng: np.random.Generator, extent: float) -> Point:
    return -extent - rng.uniform(1.5, 3.0), rng.uniform(-0.3, 0.3)


def _behind(rng: np.random.Generator, extent: float = 0.0) -> Point:
    return extent + rng.uniform(1.5, 3.0), rng.uniform(-0.3, 0.3)
