"""Balls that the arm should not touch: how they move."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

AMPLITUDE = 0.3
"""How far a ball that moves goes to each side of its middle, m."""

SAMPLES = 25
"""Places at which a ball's way is looked at."""


class BallPath(NamedTuple):
    """A ball that goes to and fro: p(t) = middle + way · sin(ωt + φ).

    Attributes:
        middle: Middle of its way, ``(3,)``, m.
        way: From there to one end, ``(3,)``, m; 0 for a ball at rest.
        frequency: ω, rad/s.
        phase: φ, rad.
    """

    middle: FloatArray
    way: FloatArray
    frequency: float
    phase: float

    def at(self, time: float) -> FloatArray:
        """Return its position ``(3,)``, m, at a time, s."""
        return self.middle + self.way * math.sin(self.frequency * time + self.phase)

    def everywhere(self) -> FloatArray:
        """Return places all along its way, ``(SAMPLES, 3)``, m."""
        shares = np.linspace(-1.0, 1.0, SAMPLES)
        return self.middle + shares[:, None] * self.way


def draw_path(
    start: FloatArray, target: FloatArray, speed: float, generator: np.random.Generator
) -> BallPath:
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
    return BallPath(middle, way, speed / AMPLITUDE, phase)
