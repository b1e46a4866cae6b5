"""Maps whose start or target is enclosed: rings, the bug trap, spirals."""

import math

import numpy as np

from aicon_envs.nav2d.maps.layout import Layout, draw_thickness, polar, wall


def ring_outside(rng: np.random.Generator) -> Layout:
    """A ring around the target, with a gap on the far side; the start is outside."""
    return _swap_ends(ring_inside(rng))


def ring_inside(rng: np.random.Generator) -> Layout:
    """A ring around the start, with a gap on the side away from the target."""
    radius = rng.uniform(1.4, 2.3)
    gap = rng.uniform(0.8, 1.2)
    thickness = draw_thickness(rng)

    # The wall runs all the way around, from one edge of the gap to the other.
    gap_middle = math.pi + rng.uniform(-1.0, 1.0)
    gap_half_angle = math.asin((gap + thickness) / 2.0 / radius)
    first = gap_middle + gap_half_angle
    last = gap_middle - gap_half_angle + 2.0 * math.pi
    ring = wall([polar(radius, angle) for angle in np.linspace(first, last, 40)], thickness)

    start = polar(rng.uniform(0.0, 0.4) * radius, rng.uniform(-math.pi, math.pi))
    target = (radius + rng.uniform(2.2, 4.0), 0.0)
    return Layout(ring, start, target)


def bug_trap(rng: np.random.Generator) -> Layout:
    """A chamber around the start, entered only by a funnel that leads in, away from the target."""
    length = rng.uniform(1.6, 2.2)
    height = rng.uniform(1.4, 1.9)
    thickness = draw_thickness(rng)

    # Half openings of the funnel at the chamber's wall and at its inner end, and its length.
    mouth = rng.uniform(0.5, 0.7) + thickness / 2.0
    throat = rng.uniform(0.4, 0.5) + thickness / 2.0
    funnel = rng.uniform(0.7, 1.2)

    # The upper half of the wall, from the throat around to the end opposite; the lower mirrors it.
    upper = [
        (-length + funnel, throat),
        (-length, mouth),
        (-0.8 * length, height),
        (0.8 * length, height),
        (length, 0.5 * height),
    ]
    lower = [(x, -y) for x, y in reversed(upper)]
    chamber = wall(upper + lower, thickness)

    start = (rng.uniform(0.0, 0.4) * length, rng.uniform(-0.3, 0.3) * height)
    target = (length + rng.uniform(1.8, 4.0), rng.uniform(-0.3, 0.3) * height)
    return Layout(chamber, start, target)


def spiral_in(rng: np.random.Generator) -> Layout:
    """A spiral around the start: r = r₀ + pitch φ / 2π; the target is outside."""
    thickness = draw_thickness(rng)
    pitch = rng.uniform(0.95, 1.2) + thickness
    turns = rng.uniform(1.4, 1.9)
    first_angle = rng.uniform(-math.pi, math.pi)
    inner_radius = rng.uniform(0.6, 0.8)

    # Thirty corners a turn.
    points = []
    for angle in np.linspace(0.0, 2.0 * math.pi * turns, round(30 * turns)):
        radius = inner_radius + pitch * angle / (2.0 * math.pi)
        points.append(polar(radius, first_angle + angle))

    target = (inner_radius + pitch * turns + rng.uniform(1.5, 3.0), 0.0)
    return Layout(wall(points, thickness), (0.0, 0.0), target)


def spiral_out(rng: np.random.Generator) -> Layout:
    """A spiral around the target; the start is outside."""
    return _swap_ends(spiral_in(rng))


def _swap_ends(layout: Layout) -> Layout:
    return Layout(layout.solid, start=layout.target, target=layout.start)
