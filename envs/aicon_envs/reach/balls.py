"""Balls that the arm should not touch: how they move."""

import math

import numpy as np

from aicon_envs.arrays import FloatArray
from aicon_envs.to_and_fro import ToAndFro

AMPLITUDE = 0.3
"""How far a ball that moves goes to each side of its middle, m."""


def draw_path(
    start: FloatArray, target: FloatArray, speed: float, generator: np.random.Generator
) -> ToAndFro:
    """Return the path of a ball that is about between two positions of the tip.

    Args:
        start: One position, ``(3,)``, m.
        target: The other.
        speed: The largest speed of the ball, m/s; 0 for one at rest.
        generator: The environment's `np_random`.
    """
    share = generator.uniform(0.2, 0.8)
    offset = generator.normal(0.0, 0.1, 3)
    direction = generator.normal(0.0, 1.0, 3)
    phase = generator.uniform(-math.pi, math.pi)

    middle = start + share * (target - start) + offset
    length = AMPLITUDE if speed > 0.0 else 0.0
    way = length * direction / np.linalg.norm(direction)
    return ToAndFro(middle, way, speed / AMPLITUDE, phase)
