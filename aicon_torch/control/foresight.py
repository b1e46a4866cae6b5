"""Foresight: the action descends the potential that the model foresees, before it is executed."""

import math
from dataclasses import dataclass

import torch
from torch import Tensor

from aicon_torch.control.action_law import low_pass
from aicon_torch.errors import OptionError
from aicon_torch.quantities import Actuator
from aicon_torch.validation import check_count, check_not_negative, check_positive

PRIME = 4093
"""p, after how many steps the dither repeats itself."""

ROUNDED = 64
"""How many times the machine's precision a component's share of a gradient is that nothing pulls:
what is left of a sum that vanishes, as for a joint whose axis goes through the tip."""


@dataclass(frozen=True)
class Foresight:
    """Eq. 2, iterated on the model's own prediction between two readings.

    The action takes K steps down the gradient, each at the state that the model foresees after the
    action so far:

        a ← δ D u,   a ← clip(a − (ρ a_max / k) ∇/‖∇‖),   k = 1 … K,

    so that it sees what it is about to do, and takes back what goes too far. Then it is low-passed
    (Sect. "Stabilizing the Control Signal"). The text takes one gradient at each reading:
    :class:`aicon_torch.control.DirectDescent`.

    The descent begins with a dither u in [−1, 1], another one at every step and the same at every
    run. Without noise, a descent that always begins at rest can repeat itself for ever: to and fro
    along a line, or around a corner. D is a_max for each component, or the actuator's own
    (``dither``). A component that nothing pulls goes back to rest; in a nullspace across several
    components, as a redundant arm has, the dither is left, so that there D had better be motions of
    the tip.

    Attributes:
        iterations: K.
        step: ρ, length of the first step as a share of the actuator's limit.
        smoothing: T, time constant of the low-pass, s; 0 switches it off.
        dither: δ, how far from rest the descent begins at most, as a share of the limit; 0 begins
            at rest.
        horizon: H, how far ahead the model foresees what the action brings, s: the time in which
            the actuator and what it moves react, where that is longer than a control step; None
            for one step.
        dither_steps: For how many steps a dither stays the same, so that an actuator that reacts in
            more than one follows it.
    """

    iterations: int = 20
    step: float = 1 / 3
    smoothing: float = 0.02
    dither: float = 1 / 3
    horizon: float | None = None
    dither_steps: int = 1

    foresees = True

    def __post_init__(self) -> None:
        """Check the constants."""
        check_count(self, ("iterations", "dither_steps"), least=1)
        check_positive(self, ("step",) if self.horizon is None else ("step", "horizon"))
        check_not_negative(self, ("smoothing", "dither"))
        if self.dither > 1:
            raise OptionError(f"dither={self.dither!r}: expected a share of the limit, 0 to 1.")

    def check(self, name: str, actuator: Actuator) -> None:
        """Its steps are shares of the actuator's limit, so there must be one."""
        limits = torch.as_tensor(actuator.limit, dtype=torch.float64, device="cpu")
        if not limits.isfinite().all():
            raise OptionError(
                f"Actuator {name!r} has limit={actuator.limit!r}: Foresight needs a finite one. "
                "Give the actuator a limit, or the policy law=DirectDescent(gain=...)."
            )

    def start(
        self, last: Tensor, steps: Tensor, actuator: Actuator, motions: Tensor | None = None
    ) -> Tensor:
        """δ D u, elsewhere at every step, ``(*B, size)``."""
        if self.dither == 0:
            return torch.zeros_like(last)
        steps = torch.floor(steps / self.dither_steps)

        # Motions as long as the limit lets them be, mixed; or one dither for each component.
        if motions is not None:
            mixture = scattered(steps, motions.shape[-1]).unsqueeze(-1)
            return actuator.clip(self.dither * (motions @ mixture).squeeze(-1))
        farthest = self.dither * actuator.limit_like(last)
        return actuator.clip(farthest * scattered(steps, actuator.size))

    def descend(
        self, action: Tensor, gradient: Tensor, iteration: Tensor, actuator: Actuator
    ) -> Tensor:
        """One step of the length ρ a_max / k, ``(*B, size)``: see :class:`ActionLaw`."""
        longest = self.step * actuator.limit_like(action) / iteration
        backward = -longest
        length = torch.linalg.vector_norm(gradient, dim=-1, keepdim=True)
        down = backward * gradient / length.clamp(min=torch.finfo(length.dtype).tiny)

        # A component that nothing pulls, or a cost that overflows, goes back to rest.
        to_rest = -torch.minimum(torch.maximum(action, backward), longest)
        pull = down.abs()
        pulls = (pull > ROUNDED * torch.finfo(pull.dtype).eps * longest) & (pull < math.inf)
        return actuator.clip(action + torch.where(pulls, down, to_rest))

    def finish(self, action: Tensor, last: Tensor, actuator: Actuator, dt: float) -> Tensor:
        """The low-pass."""
        return low_pass(action, last, self.smoothing, actuator, dt)


def scattered(steps: Tensor, size: int) -> Tensor:
    """Numbers in [−1, 1] without a pattern that a robot could follow, ``(*B, size)``.

    With h = (p − 1)/2, uᵢ(n) = ((aᵢ n² + h mod p) − h) / h: a chirp for every component, as white
    as noise, the same at every run, zero at the first step, and exact in every precision, as
    p² < 2²⁴.

    Args:
        steps: n, ``(*B,)``.
        size: Number of components.
    """
    # aᵢ = 1009ⁱ mod p, a chirp for each component. No product exceeds p², so none is rounded.
    squares = (steps % PRIME).square() % PRIME
    factors = [float(pow(1009, i, PRIME)) for i in range(1, size + 1)]
    chirps = squares[..., None] * steps.new_tensor(factors)

    half = PRIME // 2
    return ((chirps + half) % PRIME - half) / half
