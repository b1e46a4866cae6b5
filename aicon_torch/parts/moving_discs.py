"""Discs that move, such as people seen from above: how likely it is that one comes near."""

from dataclasses import dataclass

import torch
from torch import Tensor

from aicon_torch.differentiation import stop
from aicon_torch.errors import GraphError
from aicon_torch.parts.planar import norm
from aicon_torch.validation import check_not_negative, check_positive


@dataclass(frozen=True)
class MovingDiscs:
    """The cost of standing where discs will come near that go on as they went.

    Of disc i two readings p⁻ and p are a time step apart, so that v = (p − p⁻)/dt. It comes nearest
    to a robot that stands at x at the time t* = clamp(−(p − x)·v/‖v‖², 0, T), and the cost is

        Σᵢ exp(−dᵢ/(ℓ + σ t*)),   dᵢ = ‖pᵢ + vᵢ t* − x‖ − r:

    the farther ahead, the less sure it is where somebody will be.

    Attributes:
        radius: r, of a disc and the robot together, m.
        dt: Time from one reading to the next, s.
        length: ℓ, m.
        spread: σ, m/s.
        horizon: T, for how long they are followed, s.

    Raises:
        OptionError: If a number is not what it may be.

    Example:
        >>> people = MovingDiscs(radius=0.6, dt=0.1, length=0.06, spread=0.1, horizon=2.0)
        >>> estimators = [Deterministic("p_robot", moved), Recent("z_people", 2)]
        >>> Goal("avoid", Interconnection(people, ["p_robot", "z_people_recent"]))
    """

    radius: float
    dt: float
    length: float
    spread: float
    horizon: float

    def __post_init__(self) -> None:
        """Check the numbers."""
        check_positive(self, ("dt", "length"))
        check_not_negative(self, ("radius", "spread", "horizon"))

    def __call__(self, position: Tensor, recent: Tensor) -> Tensor:
        """The cost ``(*B,)``.

        Args:
            position: x, ``(*B, 2)``, m.
            recent: Where N discs were and where they are, ``(*B, 4 N)``, m.

        Raises:
            GraphError: If these are no positions in the plane.
        """
        if position.shape[-1] != 2 or recent.shape[-1] % 4:
            raise GraphError(
                f"MovingDiscs reads a position of {position.shape[-1]} numbers, and "
                f"{recent.shape[-1]} of the discs: expected 2, and 4 N, of each of N discs where "
                "it was and where it is, as Recent(..., steps=2) keeps them."
            )
        before, now = recent.reshape(*recent.shape[:-1], 2, -1, 2).unbind(-3)
        velocity, away = (now - before) / self.dt, now - position.unsqueeze(-2)

        # There the distance is stationary, or the time is an end of the horizon; and to be surer by
        # waiting is no aim.
        speed_squared = (velocity * velocity).sum(-1).clamp(min=torch.finfo(velocity.dtype).eps)
        nearest = -(away * velocity).sum(-1) / speed_squared
        nearest = stop(nearest.clamp(min=0.0).clamp(max=self.horizon))

        distance = norm(away + velocity * nearest.unsqueeze(-1)) - self.radius
        return torch.exp(-distance / (self.length + self.spread * nearest)).sum(-1)
