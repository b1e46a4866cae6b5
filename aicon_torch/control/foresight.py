"""Foresight: the action descends the potential that the model foresees, before it is executed."""

import math
from dataclasses import dataclass

import torch
from torch import Tensor

from aicon_torch.control.action_law import check_smoothing, low_pass
from aicon_torch.errors import OptionError
from aicon_torch.quantities import Actuator


@dataclass(frozen=True)
class Foresight:
    """Eq. 2, iterated on the model's own prediction between two readings.

    The action begins at rest and takes K steps down the gradient, each at the state that the model
    foresees after the action so far:

        a ← clip(a − (ρ a_max / k) ∇/‖∇‖),   k = 1 … K,

    so that it sees what it is about to do, and takes back what goes too far. Then it is low-passed
    (Sect. "Stabilizing the Control Signal"). The text takes one gradient at each reading:
    :class:`aicon_torch.control.DirectDescent`.

    Attributes:
        iterations: K.
        step: ρ, length of the first step as a share of the actuator's limit.
        smoothing: T, time constant of the low-pass, s; 0 switches it off.
    """

    iterations: int = 20
    step: float = 1 / 3
    smoothing: float = 0.02

    foresees = True

    def __post_init__(self) -> None:
        """Check the constants."""
        if not (type(self.iterations) is int and self.iterations >= 1):
            raise OptionError(f"iterations={self.iterations!r}: expected a number >= 1.")
        if not 0 < self.step < math.inf:
            raise OptionError(f"step={self.step!r}: expected a share > 0 of the actuator's limit.")
        check_smoothing(self.smoothing)

    def check(self, name: str, actuator: Actuator) -> None:
        """Its steps are shares of the actuator's limit, so there must be one."""
        limits = torch.as_tensor(actuator.limit)
        if not limits.isfinite().all():
            raise OptionError(
                f"Actuator {name!r} has limit={actuator.limit!r}: Foresight needs a finite one. "
                "Give the actuator a limit, or the policy law=DirectDescent(gain=...)."
            )

    def start(self, last: Tensor) -> Tensor:
        """At rest."""
        return torch.zeros_like(last)

    def descend(
        self, action: Tensor, gradient: Tensor, iteration: Tensor, actuator: Actuator
    ) -> Tensor:
        """One step of the length ρ a_max / k, ``(*B, size)``: see :class:`ActionLaw`."""
        # The direction; where there is none, or where a cost overflows, nothing moves.
        length = torch.linalg.vector_norm(gradient, dim=-1, keepdim=True)
        direction = gradient / length.clamp(min=torch.finfo(length.dtype).tiny)
        direction = direction.nan_to_num(nan=0.0, posinf=0.0, neginf=0.0)

        longest = self.step * torch.as_tensor(actuator.limit).to(action)
        return actuator.clip(action - longest / iteration * direction)

    def finish(self, action: Tensor, last: Tensor, actuator: Actuator, dt: float) -> Tensor:
        """The low-pass."""
        return low_pass(action, last, self.smoothing, actuator, dt)
