"""The way of what moves to and fro: a ball about an arm, a region on a board."""

import math
from typing import NamedTuple

import numpy as np

from aicon_envs.arrays import FloatArray

SAMPLES = 25
"""Places at which a way is looked at."""


class ToAndFro(NamedTuple):
    """A way to and fro: p(t) = middle + way · sin(ωt + φ), in any number n of dimensions.

    Attributes:
        middle: Middle of the way, ``(n,)``, in m, or in what the world counts in.
        way: From there to one end, ``(n,)``; 0 for what rests.
        frequency: ω, rad/s.
        phase: φ, rad.
    """

    middle: FloatArray
    way: FloatArray
    frequency: float
    phase: float

    def at(self, time: float) -> FloatArray:
        """Return the place ``(n,)`` at a time, s."""
        return self.middle + self.way * math.sin(self.frequency * time + self.phase)

    def everywhere(self, samples: int = SAMPLES) -> FloatArray:
        """Return places all along the way, ``(samples, n)``."""
        shares = np.linspace(-1.0, 1.0, samples)
        return self.middle + shares[:, None] * self.way
