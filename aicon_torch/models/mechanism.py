"""The mechanism that all models share: what happens where gradients meet, and from the gradient to the action."""

from dataclasses import dataclass
from typing import Literal

import torch

from aicon_torch.control import ActionLaw
from aicon_torch.errors import OptionError
from aicon_torch.resolution import Escape, Exploration
from aicon_torch.resolution import NullspaceProjection, Resolution, SteepestPath, Sum


@dataclass(frozen=True)
class Mechanism:
    """Options of the mechanism, which every model's options begin with.

    Attributes:
        resolution: Nullspace projection (the paper), the sum (a potential field) or the steepest path (Eq. 2).
        temperature: τ of the softmax over magnitudes; None for no softmax.
        relative: Whether the softmax is over magnitudes relative to the largest.
        by_row: Whether gradients through the same row, such as the two of a contact, are summed before they meet more.
        merge: What goes on from a meeting to the next one: the sum of the gradients, or each in its order.
        margin: Hysteresis of the order: by how much a gradient must exceed the one that held its rank.
        projector: Form of the projection, or ``"none"``; see :class:`aicon_torch.NullspaceProjection`.
        explore: Whether conflicts are explored.
        enter_cosine: Cosine below which a conflict begins.
        exit_cosine: Cosine above which it ends.
        ratio: λ, by which one gradient must exceed the other to end it.
        partner: Which gradient is compared with the dominant one: see :class:`aicon_torch.Exploration`.
        ratio_of: What λ compares.
        average_time: Time constant of the motion average, s.
        gain: k of the action law. The direction alone matters where the speed is at its limit.
        accumulate: Whether the gradient changes the velocity (Eq. 2) or sets it.
        smoothing: Time constant of the low-pass on the velocity, s.
        dtype: Precision of the estimates.
    """

    resolution: Literal["nullspace", "sum", "steepest"] = "nullspace"
    temperature: float | None = 0.8
    relative: bool = True
    by_row: bool = True
    merge: Literal["sum", "order"] = "sum"
    margin: float = 0.1
    projector: Literal["orthogonal", "qr", "pinv", "none"] = "orthogonal"
    explore: bool = True
    enter_cosine: float = -0.6
    exit_cosine: float = -0.4
    ratio: float = 3.0
    partner: Literal["second", "opposing"] = "opposing"
    ratio_of: Literal["weights", "magnitudes"] = "magnitudes"
    average_time: float = 0.4
    gain: float = 1e9
    accumulate: bool = False
    smoothing: float = 0.1
    dtype: torch.dtype = torch.float64

    def rule(self, escape: Escape | None = None) -> Resolution:
        """The resolution that the options name, with what escaping a trap needs beyond the text."""
        if self.resolution == "sum":
            return Sum()
        if self.resolution == "steepest":
            return SteepestPath()
        if self.resolution != "nullspace":
            raise OptionError(f"resolution={self.resolution!r}: expected 'nullspace', 'sum' or 'steepest'.")
        exploration = Exploration(
            self.enter_cosine,
            self.exit_cosine,
            self.ratio,
            self.average_time,
            escape or Escape(),
            self.partner,
            self.ratio_of,
        )
        return NullspaceProjection(
            self.temperature,
            self.margin,
            self.projector,
            relative=self.relative,
            by_row=self.by_row,
            exploration=exploration if self.explore else None,
        )

    def law(self) -> ActionLaw:
        """From the gradient to the action."""
        return ActionLaw(self.gain, self.accumulate, self.smoothing)
