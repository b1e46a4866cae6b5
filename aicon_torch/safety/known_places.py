"""The places at which the goals are reached that are known: a short list with a head."""

from typing import NamedTuple

import torch
from torch import Tensor

APART = 0.4  # places nearer to each other than this, in the action's unit times s, are one


class Known(NamedTuple):
    """Up to k places, as ways from here. The least often tried one leads, and of these the nearest.

    Attributes:
        is_place: Whether there is one, ``(k, *B)``.
        ways: The ways to them, ``(k, *B, n)``.
        tries: How often the actuator went to each, ``(k, *B)``.
    """

    is_place: Tensor
    ways: Tensor
    tries: Tensor

    def head(self, limits: Tensor) -> Tensor:
        """Which place leads, ``(k, *B)``; True once in a column that has a place.

        Args:
            limits: Of the actuator, ``(n,)``.
        """
        rank = self._rank(limits)
        return self.is_place & first_of(rank == rank.amin(0))

    def with_one(self, way: Tensor, is_new: Tensor, limits: Tensor) -> "Known":
        """The list with one more, instead of the last one if that is worse; none twice.

        Args:
            way: The way to it, ``(*B, n)``.
            is_new: Whether there is one, ``(*B,)``.
            limits: Of the actuator, ``(n,)``.
        """
        is_same = self.is_place & ((self.ways - way).abs().amax(-1) < APART)
        rank = self._rank(limits)
        is_better = _share(way, limits) < rank.amax(0)
        is_taken = is_new & is_better & ~is_same.any(0)

        replaced = is_taken & first_of(rank == rank.amax(0))
        return Known(
            is_place=self.is_place | replaced,
            ways=torch.where(replaced.unsqueeze(-1), way, self.ways),
            tries=torch.where(replaced, 0.0, self.tries),
        )

    def _rank(self, limits: Tensor) -> Tensor:
        """The tries, and as a fraction how far away it is, ``(k, *B)``; ∞ where there is none."""
        return torch.where(self.is_place, self.tries + _share(self.ways, limits), torch.inf)


def first_of(mask: Tensor) -> Tensor:
    """The first that is True in each column ``(m, *B)``, alone."""
    return mask & (mask.cumsum(0) == 1)


def time_of(way: Tensor, limits: Tensor) -> Tensor:
    """How long a way ``(*B, n)`` takes at full speed, ``(*B,)``, s; of a velocity its share."""
    return (way.abs() / limits.to(way)).amax(-1)


def _share(way: Tensor, limits: Tensor) -> Tensor:
    """t/(1 + t) of the time t of a way ``(*B, n)`` at full speed, ``(*B,)``: below 1."""
    time = time_of(way, limits)
    return time / (1.0 + time)
