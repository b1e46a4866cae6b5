"""A pusher that a PD controller moves to position targets."""

from dataclasses import dataclass

import torch
from torch import Tensor

from aicon_torch.differentiation import values_only
from aicon_torch.errors import OptionError
from aicon_torch.estimation import Estimator
from aicon_torch.interconnections import Values
from aicon_torch.quantities import as_count, as_number

PARTS = 5
"""Number of parts of a step in which a motion is followed."""


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

        Raises:
            OptionError: If there is no sub-step, or a number but the damping is not positive.
        """
        if as_count(substeps) < 1:
            raise OptionError(f"substeps={substeps!r}: expected a whole number > 0.")
        for name, number in (("stiffness", stiffness), ("substep", substep)):
            if not as_number(number) > 0:
                raise OptionError(f"{name}={number!r}: expected a number > 0.")

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

    def target_offset(self, a: Tensor, v_pusher: Tensor, dt: float | Tensor) -> Tensor:
        """The target's offset from the pusher that yields a mean velocity over the next step.

        Args:
            a: The mean velocity, ``(*B, 2)``, m/s.
            v_pusher: The velocity now, ``(*B, 2)``, m/s.
            dt: Duration of the step, s.

        Returns:
            ``(*B, 2)``, m.
        """
        # The o of by_offset · o + by_velocity · v = a dt.
        by_offset, by_velocity = self.displacement_by_offset[-1], self.displacement_by_velocity[-1]
        return (a * dt - by_velocity * v_pusher) / by_offset

    def final_velocity(self, v_pusher: Tensor, a: Tensor, dt: float | Tensor) -> Tensor:
        """The velocity at the end of a step with mean velocity a, ``(*B, 2)``, m/s."""
        offset = self.target_offset(a, v_pusher, dt)
        return self.velocity_by_offset * offset + self.velocity_by_velocity * v_pusher

    def displacements(self, a: Tensor, v_pusher: Tensor, dt: float | Tensor, parts: int) -> Tensor:
        """The displacements after equally long parts of a step with mean velocity a.

        Args:
            a: The mean velocity, ``(*B, 2)``, m/s.
            v_pusher: The velocity at the beginning, ``(*B, 2)``, m/s.
            dt: Duration of the step, s.
            parts: Number n of the parts, at most that of the sub-steps.

        Returns:
            ``(*B, 2n)``, m.

        Raises:
            OptionError: If there are fewer sub-steps than parts.
        """
        substeps = len(self.displacement_by_offset)
        if not 0 < parts <= substeps:
            raise OptionError(
                f"parts={parts!r}: expected 1 to {substeps}, the number of sub-steps."
            )

        # The sub-step with which each part ends, to the nearest.
        ends = [round((part + 1) * substeps / parts) - 1 for part in range(parts)]
        by_offset = a.new_tensor([self.displacement_by_offset[end] for end in ends])
        by_velocity = a.new_tensor([self.displacement_by_velocity[end] for end in ends])

        offset = self.target_offset(a, v_pusher, dt)
        moved: Tensor = by_offset.unsqueeze(-1) * offset.unsqueeze(-2)
        moved = moved + by_velocity.unsqueeze(-1) * v_pusher.unsqueeze(-2)
        return moved.flatten(-2)


class PusherMotion(Estimator):
    """d_pusher, v_pusher: the way of a pusher through its last step, and its velocity at the end.

    d_pusher ``(*B, 2n)``, m, are its displacements after each of n equal parts of the step.

    Args:
        servo: What moves it; None if it moves evenly.
    """

    outputs = ("d_pusher", "v_pusher")
    inputs = ("v_pusher", "a", "dt")

    at_rest: Tensor

    def __init__(self, servo: Servo | None) -> None:
        super().__init__()
        self.servo = servo
        substeps = PARTS if servo is None else len(servo.displacement_by_offset)
        self.parts = min(PARTS, substeps)
        self.register_buffer("at_rest", torch.zeros(2 * self.parts))

    def initial(self, values: Values) -> dict[str, Tensor]:
        """The pusher was at rest."""
        return {"d_pusher": self.at_rest, "v_pusher": self.at_rest[:2]}

    @values_only
    def update(self, values: Values) -> dict[str, Tensor]:
        """How the last action moved it."""
        return {name: self(values, name) for name in self.outputs}

    def forward(self, values: Values, output: str) -> Tensor:
        """How the action moves it."""
        a, v_pusher, dt = values["a"], values["v_pusher"], values["dt"]
        if output == "v_pusher":
            return a if self.servo is None else self.servo.final_velocity(v_pusher, a, dt)
        if self.servo is None:
            return even_motion(a * dt, self.parts)
        return self.servo.displacements(a, v_pusher, dt, self.parts)


def even_motion(displacement: Tensor, parts: int = PARTS) -> Tensor:
    """The displacements ``(*B, d n)`` after each of n parts of an even motion ``(*B, d)``."""
    shares = torch.arange(1, parts + 1, dtype=displacement.dtype, device=displacement.device)
    moved: Tensor = (shares / parts).unsqueeze(-1) * displacement.unsqueeze(-2)
    return moved.flatten(-2)


@dataclass(frozen=True)
class PositionTarget:
    """The position target that yields a mean velocity, within a square workspace.

    Attributes:
        servo: The controller that follows the target; None stands for one that follows at once.
        workspace: Lowest and highest coordinate of a target, m.
    """

    servo: Servo | None
    workspace: tuple[float, float]

    def __call__(self, a: Tensor, x_pusher: Tensor, v_pusher: Tensor, dt: float | Tensor) -> Tensor:
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
