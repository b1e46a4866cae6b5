"""The action law: from the gradient at an actuator to the next action."""

from dataclasses import dataclass

import torch
from torch import Tensor

from aicon_torch.errors import OptionError
from aicon_torch.quantities import Actuator


@dataclass(frozen=True)
class ActionLaw:
    """a* = −k∇, or a* = a − k∇ where it accumulates (Eq. 2); then a ← a + α (clip(a*) − a).

    The low-pass of Sect. "Stabilizing the Control Signal" has α = dt/(dt + T).

    Attributes:
        gain: k, in the action's unit squared over the cost's.
        accumulate: Whether the gradient changes the action (Eq. 2) or sets it.
        smoothing: T, time constant of the low-pass, s; 0 switches it off.
    """

    gain: float
    accumulate: bool = False
    smoothing: float = 0.1

    def __post_init__(self) -> None:
        """Check the constants."""
        if not self.gain > 0 or not self.smoothing >= 0:
            raise OptionError(f"gain={self.gain!r}: expected > 0; smoothing={self.smoothing!r}: expected >= 0 (s).")

    def __call__(self, gradient: Tensor, action: Tensor, actuator: Actuator, dt: float) -> Tensor:
        """The next action.

        Args:
            gradient: ∇ at the actuator, ``(*B, size)``.
            action: The last action, ``(*B, size)``.
            actuator: Whose limit holds.
            dt: Time step, s.

        Returns:
            ``(*B, size)``, within the limit.
        """
        wish = actuator.clip(action - self.gain * gradient if self.accumulate else -self.gain * gradient)
        wish = wish.nan_to_num(nan=0.0)  # a cost that overflows moves nothing
        if self.smoothing == 0:
            return wish
        return actuator.clip(torch.lerp(action, wish, dt / (dt + self.smoothing)))
