"""The noise of N worlds, each from a generator of its own."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from aicon_envs.arrays import FloatArray
from aicon_envs.nav2d.physics import Physics

_BLOCK = 128
"""Steps whose noise is drawn at once."""


class StepNoise(NamedTuple):
    """The noise of one step.

    Attributes:
        velocity: On the velocity, (2, N), m/s.
        bearing: On the direction to the target, (N,), rad.
        clearance: On the clearance, (N,), m.
        obstacle_bearing: On the direction to the nearest obstacle point, (N,), rad.
    """

    velocity: FloatArray
    bearing: FloatArray
    clearance: FloatArray
    obstacle_bearing: FloatArray


class NoiseStream:
    """Normal numbers for N worlds, five a step, with the standard deviations of the physics.

    The numbers are drawn in blocks; the block length does not change them, because a generator
    yields the same sequence however it is cut.

    Args:
        num_worlds: Number N of worlds.
        physics: Has the standard deviations.
    """

    def __init__(self, num_worlds: int, physics: Physics) -> None:
        """Prepare the streams; `restart` each before it is used."""
        actuation = physics.actuation_noise
        bearing = physics.bearing_noise
        self._deviations = np.array([actuation, actuation, bearing, physics.range_noise, bearing])

        self._generators = [np.random.default_rng(0) for _ in range(num_worlds)]
        self._block: FloatArray = np.zeros((_BLOCK, len(self._deviations), num_worlds))
        self._next = 0  # row of the block for the next step
        self._current: FloatArray = np.zeros((len(self._deviations), num_worlds))

    @property
    def current(self) -> StepNoise:
        """The noise of this step."""
        numbers = self._current
        return StepNoise(numbers[:2], numbers[2], numbers[3], numbers[4])

    def restart(self, indices: Sequence[int], generators: Sequence[np.random.Generator]) -> None:
        """Begin anew in the worlds `indices`, with a generator for each."""
        for index, generator in zip(indices, generators, strict=True):
            self._generators[index] = generator
            self._current[:, index] = self._draw(generator, 1)[0]
            # Only what is left of the block: the other worlds are in the middle of it.
            self._block[self._next :, :, index] = self._draw(generator, _BLOCK - self._next)

    def advance(self) -> StepNoise:
        """Go on to the next step, and return its noise."""
        if self._next == _BLOCK:
            self._next = 0
            for index, generator in enumerate(self._generators):
                self._block[:, :, index] = self._draw(generator, _BLOCK)

        self._current = self._block[self._next]
        self._next += 1
        return self.current

    def _draw(self, generator: np.random.Generator, steps: int) -> FloatArray:
        numbers: FloatArray = generator.standard_normal((steps, len(self._deviations)))
        numbers *= self._deviations
        return numbers
