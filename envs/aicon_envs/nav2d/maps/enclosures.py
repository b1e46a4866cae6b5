"""Maps whose start or target is enclosed: rings, the bug trap, spirals."""

import math

import numpy as np

from aicon_envs.nav2d.maps.sketch import Sketch, draw_thickness, polar, wall


def ring_outside(rng: np.random.Generator) -> Sketch:
    """A ring around the target, with a gap on the far side; the start is outside."""
    return _swap(ring_inside(rng))


def ring_inside(rng: np.random.Generator) -> Sketch:
    """A ring around the start, with a gap on the side away from the target."""
    radius, gap, thickness = rng.uniform(1.4, 2.3), rng.uniform(0.8, 1.2), draw_thickness(rng)
    middle = math.pi + rng.uniform(-1.0, 1.0)
    half = math.asin((gap + thickness) / 2.0 / radius)
    angles = np.linspace(middle + half, middle - half + 2.0 * math.pi, 40)
    start = polar(rng.uniform(0.0, 0.4) * radius, rng.uniform(-math.pi, math.pi))
    return Sketch(
        wall([polar(radius, angle) for angle in angles], thickness), start, (radius + rng.uniform(2.2, 4.0), 0.0)
    )


def bug_trap(rng: np.random.Generator) -> Sketch:
    """A chamber around the start whose only entrance is a funnel that leads inwards, away from the target."""
    length, height, thickness = rng.uniform(1.6, 2.2), rng.uniform(1.4, 1.9), draw_thickness(rng)
    mouth, throat = rng.uniform(0.5, 0.7) + thickness / 2.0, rng.uniform(0.4, 0.5) + thickness / 2.0
    lip = rng.uniform(0.7, 1.2)
    upper = [
        (-length + lip, throat),
        (-length, mouth),
        (-0.8 * length, height),
        (0.8 * length, height),
        (length, 0.5 * height),
    ]
    solid = wall([*upper, *((x, -y) for x, y in reversed(upper))], thickness)
    start = (rng.uniform(0.0, 0.4) * length, rng.uniform(-0.3, 0.3) * height)
    return Sketch(solid, start, (length + rng.uniform(1.8, 4.0), rng.uniform(-0.3, 0.3) * height))


def spiral_in(rng: np.random.Generator) -> Sketch:
    """A spiral around the start: r = r₀ + pitch φ / 2π; the target is outside."""
    thickness = draw_thickness(rng)
    pitch, turns, first = rng.uniform(0.95, 1.2) + thickness, rng.uniform(1.4, 1.9), rng.uniform(-math.pi, math.pi)
    inner = rng.uniform(0.6, 0.8)
    angles = np.linspace(0.0, 2.0 * math.pi * turns, round(30 * turns))
    solid = wall([polar(inner + pitch * angle / (2.0 * math.pi), first + angle) for angle in angles], thickness)
    return Sketch(solid, (0.0, 0.0), (inner + pitch * turns + rng.uniform(1.5, 3.0), 0.0))


def spiral_out(rng: np.random.Generator) -> Sketch:
    """A spiral around the target; the start is outside."""
    return _swap(spiral_in(rng))


def _swap(sketch: Sketch) -> Sketch:
    return Sketch(sketch.solid, sketch.target, sketch.start)
