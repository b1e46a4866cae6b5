"""The action law: from the gradient at an actuator to the next action."""

from dataclasses import dataclass

import torch
from torch import Tensor

from aicon_torch.errors import OptionError
from aicon_torch.quantities import Actuator


@dataclass(frozen=True)
class ActionLaw:
    """a* = −k∇, or a* = a − k∇ where it accumulates (Eq. 2); then a ← a + α (clip(a*) − a).

    The low-pass of Sect. "Stabilizing the Control Signal" has α = dt/(dt + T). With the default
    gain the action is as large as its limit allows, wherever the gradient is not next to zero: the
    gradient gives the direction.

    Attributes:
        gain: k, in the action's unit squared over the cost's.
        accumulate: Whether the gradient changes the action (Eq. 2) or sets it.
        smoothing: T, time constant of the low-pass, s; 0 switches it off.
    """

    gain: float = 1e9
    accumulate: bool = False
    smoothing: float = 0.1

    def __post_init__(self) -> None:
        """Check the constants."""
        if not self.gain > 0:
            raise OptionError(f"gain={self.gain!r}: expected a number > 0.")
        if not self.smoothing >= 0:
            raise OptionError(f"smoothing={self.smoothing!r}: expected a time >= 0 (s).")

    @classmethod
    def as_in_paper(cls, gain: float) -> "ActionLaw":
        """Eq. 2, which changes the action by −k∇; the text leaves k to the reader."""
        return cls(gain=gain, accumulate=True)

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
        descent = -self.gain * gradient
        if self.accumulate:
            descent = action + descent
        target = actuator.clip(descent).nan_to_num(nan=0.0)  # a cost that overflows moves nothing

        if self.smoothing == 0:
            return target
        rate = dt / (dt + self.smoothing)
        return actuator.clip(torch.lerp(action, target, rate))
