"""The pusher: a disc that a PD controller moves to position targets."""

from typing import NamedTuple

import torch
from torch import Tensor

RADIUS = 15.0
"""Radius of the pusher, px."""

WORKSPACE = 512.0
"""Side of the square in which targets may lie, px."""


class Servo(NamedTuple):
    """The PD controller v ← v + h (k_p e − k_v v), x ← x + h v, as a linear map of offset and velocity.

    After k sub-steps a pusher with velocity v, whose target lies at an offset o, has moved by follow[k]·o + drift[k]·v.

    Attributes:
        follow: Share of the offset covered after each of n sub-steps.
        drift: Share of the velocity kept as displacement after each sub-step, s.
        kick: Velocity at the end by offset, 1/s.
        keep: Velocity at the end by velocity.
    """

    follow: tuple[float, ...]
    drift: tuple[float, ...]
    kick: float
    keep: float

    @classmethod
    def of(cls, stiffness: float = 100.0, damping: float = 20.0, substep: float = 0.01, substeps: int = 10) -> "Servo":
        """The map of the benchmark's gains.

        Args:
            stiffness: k_p, 1/s².
            damping: k_v, 1/s.
            substep: h, s.
            substeps: n, number of sub-steps in a control step.
        """
        accelerate = torch.tensor([[1.0, 0.0], [-stiffness * substep, 1 - damping * substep]], dtype=torch.float64)
        once = torch.tensor([[1.0, substep], [0.0, 1.0]], dtype=torch.float64) @ accelerate  # of (−o, v)
        powers = torch.stack([torch.linalg.matrix_power(once, k + 1) for k in range(substeps)])
        kick, keep = powers[-1, 1].tolist()
        return cls(tuple((1 - powers[:, 0, 0]).tolist()), tuple(powers[:, 0, 1].tolist()), -kick, keep)

    def offset(self, a: Tensor, v_pusher: Tensor, dt: float) -> Tensor:
        """The target's offset that yields a mean velocity a over the next step, ``(*B, 2)``, px."""
        return (a * dt - self.drift[-1] * v_pusher) / self.follow[-1]

    def velocity(self, v_pusher: Tensor, a: Tensor, dt: float) -> Tensor:
        """The velocity at the end of a step with mean velocity a, ``(*B, 2)``, px/s."""
        return self.kick * self.offset(a, v_pusher, dt) + self.keep * v_pusher

    def target(self, a: Tensor, x_pusher: Tensor, v_pusher: Tensor, dt: float) -> Tensor:
        """The position target that yields a mean velocity a, within the workspace, ``(*B, 2)``, px."""
        return (x_pusher + self.offset(a, v_pusher, dt)).clamp(0.0, WORKSPACE)

    def farthest(self, bound: Tensor, speed: Tensor) -> Tensor:
        """The displacement at the end of a step in which no sub-step goes beyond a bound.

        Args:
            bound: Largest displacement in some direction, ``(*B)``, px.
            speed: Velocity in that direction at the beginning, ``(*B)``, px/s.

        Returns:
            ``(*B)``, px; at most the bound.
        """
        follow, drift = bound.new_tensor(self.follow), bound.new_tensor(self.drift)
        offset = ((bound.unsqueeze(-1) - drift * speed.unsqueeze(-1)) / follow).amin(-1)
        return torch.minimum(bound, self.follow[-1] * offset + self.drift[-1] * speed)
