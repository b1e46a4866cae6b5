"""A pusher that a PD controller moves to position targets."""

from dataclasses import dataclass

import torch
from torch import Tensor


@dataclass(frozen=True)
class Servo:
    """The PD controller v ← v + h (k_p e − k_v v), x ← x + h v, as a linear map over a step.

    A pusher with velocity v whose target lies at an offset o has after k sub-steps moved by
    ``displacement_by_offset[k]``·o + ``displacement_by_velocity[k]``·v, and after the last one it
    has the velocity ``velocity_by_offset``·o + ``velocity_by_velocity``·v. Build one with
    :meth:`of`.

    Attributes:
        displacement_by_offset: After each of n sub-steps.
        displacement_by_velocity: Likewise, s.
        velocity_by_offset: At the end, 1/s.
        velocity_by_velocity: At the end.
    """

    displacement_by_offset: tuple[float, ...]
    displacement_by_velocity: tuple[float, ...]
    velocity_by_offset: float
    velocity_by_velocity: float

    @classmethod
    def of(
        cls,
        stiffness: float = 100.0,
        damping: float = 20.0,
        substep: float = 0.01,
        substeps: int = 10,
    ) -> "Servo":
        """The map of a controller's gains, by default those of the benchmark pushT.

        Args:
            stiffness: k_p, 1/s².
            damping: k_v, 1/s.
            substep: h, s.
            substeps: n, number of sub-steps in a control step.
        """
        # One sub-step as a matrix that acts on (−o, v).
        accelerate = [[1.0, 0.0], [-stiffness * substep, 1 - damping * substep]]
        move = [[1.0, substep], [0.0, 1.0]]
        once = torch.tensor(move, dtype=torch.float64) @ torch.tensor(
            accelerate, dtype=torch.float64
        )

        # All of them: what is left of the offset, and the velocity.
        powers = torch.stack([torch.linalg.matrix_power(once, k + 1) for k in range(substeps)])
        velocity_by_offset, velocity_by_velocity = powers[-1, 1].tolist()
        return cls(
            displacement_by_offset=tuple((1 - powers[:, 0, 0]).tolist()),
            displacement_by_velocity=tuple(powers[:, 0, 1].tolist()),
            velocity_by_offset=-velocity_by_offset,
            velocity_by_velocity=velocity_by_velocity,
        )

    def target_offset(self, a: Tensor, v_pusher: Tensor, dt: float) -> Tensor:
        """The target's offset from the pusher that yields a mean velocity over the next step.

        Args:
            a: The mean velocity, ``(*B, 2)``, m/s.
            v_pusher: The velocity now, ``(*B, 2)``, m/s.
            dt: Duration of the step, s.

        Returns:
            ``(*B, 2)``, m.
        """
        by_offset, by_velocity = self.displacement_by_offset[-1], self.displacement_by_velocity[-1]
        return (a * dt - by_velocity * v_pusher) / by_offset

    def final_velocity(self, v_pusher: Tensor, a: Tensor, dt: float) -> Tensor:
        """The velocity at the end of a step with mean velocity a, ``(*B, 2)``, m/s."""
        offset = self.target_offset(a, v_pusher, dt)
        return self.velocity_by_offset * offset + self.velocity_by_velocity * v_pusher

    def largest_displacement(self, bound: Tensor, speed: Tensor) -> Tensor:
        """The displacement at the end of a step in which no sub-step goes beyond a bound.

        Args:
            bound: Largest displacement in some direction, ``(*B,)``, m.
            speed: Velocity in that direction at the beginning, ``(*B,)``, m/s.

        Returns:
            ``(*B,)``, m; at most the bound.
        """
        by_offset = bound.new_tensor(self.displacement_by_offset)
        by_velocity = bound.new_tensor(self.displacement_by_velocity)

        offsets = (bound.unsqueeze(-1) - by_velocity * speed.unsqueeze(-1)) / by_offset
        offset = offsets.amin(-1)  # the sub-step that would go farthest decides
        last = self.displacement_by_offset[-1] * offset + self.displacement_by_velocity[-1] * speed
        return torch.minimum(bound, last)


@dataclass(frozen=True)
class PositionTarget:
    """The position target that yields a mean velocity, within a square workspace.

    Attributes:
        servo: The controller that follows the target; None stands for one that follows at once.
        workspace: Lowest and highest coordinate of a target, m.
    """

    servo: Servo | None
    workspace: tuple[float, float]

    def __call__(self, a: Tensor, x_pusher: Tensor, v_pusher: Tensor, dt: float) -> Tensor:
        """The target.

        Args:
            a: The mean velocity over the next step, ``(*B, 2)``, m/s.
            x_pusher: The pusher's position, ``(*B, 2)``, m.
            v_pusher: Its velocity now, ``(*B, 2)``, m/s.
            dt: Duration of the step, s.

        Returns:
            ``(*B, 2)``, m.
        """
        offset = a * dt if self.servo is None else self.servo.target_offset(a, v_pusher, dt)
        return (x_pusher + offset).clamp(*self.workspace)
