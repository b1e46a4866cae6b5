"""Meetings: the gradients that arrive at one quantity, as resolutions and explorations see them."""

from collections.abc import Callable
from typing import NamedTuple

from torch import Tensor


class GradientStack(NamedTuple):
    """The gradients that meet at one quantity, and what is known there.

    Attributes:
        gradients: One row for each candidate, ``(*B, n, d)``.
        goals: For each candidate the goals that it comes from.
        motion: Latest motion of the quantity, ``(*B, d)``, per step.
        costs: Cost of each goal now, ``(*B,)``.
        displaced: Cost of a goal now had the quantity been displaced, ``(name, (*B, d)) -> (*B,)``.
        dt: Time step, s.
        final: Whether gradients meet nowhere else on the way from here to the actuators.
        siblings: Which candidates left an earlier meeting together, ``(n, n)``; None if none did.
        before: Which of them, j, came before candidate i there and keep their place, ``(n, n)``.
    """

    gradients: Tensor
    goals: tuple[frozenset[str], ...]
    motion: Tensor
    costs: dict[str, Tensor]
    displaced: Callable[[str, Tensor], Tensor]
    dt: float
    final: bool = True
    siblings: Tensor | None = None
    before: Tensor | None = None

    @property
    def concerned(self) -> frozenset[str]:
        """The goals whose gradients arrive here, alone or merged."""
        return frozenset().union(*self.goals)


class Ranked(NamedTuple):
    """The gradients of a meeting by magnitude.

    Attributes:
        norms: Magnitudes ‖∇ᵢ‖, ``(*B, n)``.
        units: Directions, ``(*B, n, d)``.
        weights: Normalised magnitudes wᵢ, ``(*B, n)``.
        scaled: The gradients at these magnitudes, ``(*B, n, d)``.
        first: Index of the dominant one, ``(*B, 1)``.
    """

    norms: Tensor
    units: Tensor
    weights: Tensor
    scaled: Tensor
    first: Tensor
