"""The first belief about something that is read."""

from collections.abc import Callable
from dataclasses import dataclass

import torch
from torch import Tensor
from torch.nn.functional import pad

from aicon_torch.interconnections import Interconnection


@dataclass(frozen=True)
class ReadingPrior:
    """It is as it is read at first, and what is not read is zero.

    Attributes:
        variances: Of each component, those that are read first, in their units squared.
    """

    variances: tuple[float, ...]

    def __call__(self, reading: Tensor) -> tuple[Tensor, Tensor]:
        """Mean ``(*B, n)`` and covariance ``(n, n)`` by a reading ``(*B, k)`` of k ≤ n of them."""
        unread = len(self.variances) - reading.shape[-1]
        return pad(reading, (0, unread)), torch.diag(reading.new_tensor(self.variances))


def first_belief(prior: Callable[..., tuple[Tensor, Tensor]], reading: str) -> Interconnection:
    """What an :class:`aicon_torch.EKF` begins with: mean and covariance by the first reading."""
    return Interconnection(prior, [reading])
