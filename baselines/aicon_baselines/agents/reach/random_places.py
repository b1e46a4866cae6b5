"""Random places: the most trivial escape, for methods that have none of their own."""

import math
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray

from aicon_torch.safety.places import ARRIVED, PROGRESS, SLOW, spread

FloatArray = NDArray[np.float64]

PATIENCE = 0.8
"""Held up is one that has made no progress for so long, s."""

BLOCKED, LONGEST = 0.1, 2.5
"""A way ends where it has been slow for so long, or late, s."""

NEAR = 0.008
"""A cost below which it has arrived, and is not held up, m."""

WIDEST = math.pi
"""Joints without stops go as far as this to either side, rad."""


@dataclass
class RandomPlaces:
    """Where an arm goes that is held up: to a place in the middle half of all ranges, and again.

    The places are those of the policies' own sequence (`aicon_torch.safety.places.spread`).

    Attributes:
        low: Lower limits of the joints, ``(n,)``, rad or m; −∞ where there is none.
        high: Upper limits.
        dt: Time step, s.
        place: Where it goes, ``(n,)``; None where it follows its target.
        number: Of the next place.
        lowest: The cost that counts as progress, m.
        clock: For how long there was none, or for how long it has been on its way, s.
        slow: For how long it has been slow, s.
    """

    low: FloatArray
    high: FloatArray
    dt: float
    place: FloatArray | None = None
    number: int = 0
    lowest: float = math.inf
    clock: float = 0.0
    slow: float = 0.0

    def way(self, joints: FloatArray, cost: float) -> FloatArray | None:
        """The way from here to its place, ``(n,)``; None where it follows its target.

        Args:
            joints: Where it is, ``(n,)``, rad or m.
            cost: What is missing to its target, m.
        """
        if self.place is not None and self._is_over(joints):
            self.place, self.lowest, self.clock = None, math.inf, 0.0
        elif self.place is None:
            self._follow(cost)
        return None if self.place is None else self.place - joints

    def moved(self, share: float) -> None:
        """Note how fast it moves, as a share of the speed of its fastest joint."""
        self.slow = self.slow + self.dt if share < SLOW else 0.0
        self.clock += self.dt

    def _is_over(self, joints: FloatArray) -> bool:
        """Whether its way ends here."""
        is_there = self.place is not None and np.abs(self.place - joints).max() < ARRIVED
        return bool(is_there or self.slow >= BLOCKED or self.clock >= LONGEST)

    def _follow(self, cost: float) -> None:
        """Whether it is held up."""
        if cost < max(NEAR, (1.0 - PROGRESS) * self.lowest):
            self.lowest, self.clock = cost, 0.0
        elif self.clock >= PATIENCE:
            is_ranged = np.isfinite(self.low) & np.isfinite(self.high)
            low = np.where(is_ranged, self.low, -WIDEST)
            high = np.where(is_ranged, self.high, WIDEST)
            share = spread(torch.tensor(self.number), torch.from_numpy(low)).numpy()
            self.place = (low + high) / 2 + share * (high - low) / 4
            self.number, self.clock, self.slow = self.number + 1, 0.0, 0.0
