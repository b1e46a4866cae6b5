"""The paper's action law: one gradient a step, at the current estimates."""

from dataclasses import dataclass

from torch import Tensor

from aicon_torch.control.action_law import low_pass
from aicon_torch.quantities import Actuator
from aicon_torch.validation import check_flags, check_not_negative, check_positive


@dataclass(frozen=True)
class DirectDescent:
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

    iterations = 1
    foresees = False
    horizon = None

    def __post_init__(self) -> None:
        """Check the constants."""
        check_positive(self, ("gain",))
        check_not_negative(self, ("smoothing",))
        check_flags(self)

    @classmethod
    def as_in_paper(cls, gain: float) -> "DirectDescent":
        """Eq. 2, which changes the action by −k∇; the text leaves k to the reader."""
        return cls(gain=gain, accumulate=True)

    def check(self, name: str, actuator: Actuator) -> None:
        """It drives any."""

    def start(
        self, last: Tensor, steps: Tensor, actuator: Actuator, motions: Tensor | None = None
    ) -> Tensor:
        """The last action, which Eq. 2 changes."""
        return last

    def descend(
        self, action: Tensor, gradient: Tensor, iteration: Tensor, actuator: Actuator
    ) -> Tensor:
        """clip(a*), ``(*B, size)``: see :class:`ActionLaw`."""
        descent = -self.gain * gradient
        if self.accumulate:
            descent = action + descent
        return actuator.clip(descent).nan_to_num(nan=0.0)  # a cost that overflows moves nothing

    def finish(self, action: Tensor, last: Tensor, actuator: Actuator, dt: float) -> Tensor:
        """The low-pass."""
        return low_pass(action, last, self.smoothing, actuator, dt)
