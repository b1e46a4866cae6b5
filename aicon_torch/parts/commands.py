"""Commands of robots that take no velocities: a force, or a displacement."""

from dataclasses import dataclass

from torch import Tensor

from aicon_torch.validation import check_positive
from aicon_torch.vectors import shorten


@dataclass(frozen=True)
class ForceServo:
    """The force that brings a mass to a velocity with the time constant τ: a first-order servo.

        F = m (a − v)/τ,   no longer than F_max,

    so that m dv/dt = F becomes dv/dt = (a − v)/τ. A force that is held over a step does so
    for τ ≥ dt.

    Attributes:
        mass: m, kg.
        time: τ, s.
        largest: F_max, N.

    Raises:
        OptionError: If a number is not what it may be.

    Example:
        >>> servo = ForceServo(mass=2.0, time=0.1, largest=40.0)
        >>> Actuator(2, "m/s", limit=0.5, command=servo)  # in a graph with an estimate "v_robot"
        >>> Deterministic("x_rob", servo.displacement, is_motion=True)
    """

    mass: float
    time: float
    largest: float

    def __post_init__(self) -> None:
        """Check the numbers."""
        check_positive(self, ("mass", "time", "largest"))

    def __call__(self, a: Tensor, v_robot: Tensor) -> Tensor:
        """F, ``(*B, d)``, N.

        Args:
            a: The nominal velocity, ``(*B, d)``, m/s.
            v_robot: The velocity now, ``(*B, d)``, m/s.
        """
        force = self.mass / self.time * (a - v_robot)
        return shorten(force, self.largest)

    def displacement(self, a: Tensor, v_robot: Tensor, dt: Tensor) -> Tensor:
        """How far the mass goes in a step: v dt + F dt²/(2m), ``(*B, d)``, m.

        Args:
            a: The nominal velocity, ``(*B, d)``, m/s.
            v_robot: The velocity now, ``(*B, d)``, m/s.
            dt: Duration of the step, s.
        """
        return v_robot * dt + self(a, v_robot) * (dt**2 / (2 * self.mass))


@dataclass(frozen=True)
class DisplacementCommand:
    """The displacement of the next step in the robot's own units, a dt/s, within ±1 each.

    Attributes:
        unit: s, the displacement that the command 1 stands for, m.

    Raises:
        OptionError: If it is not positive.

    Example:
        >>> Actuator(3, "m/s", limit=1.0, command=DisplacementCommand(unit=0.05))
    """

    unit: float

    def __post_init__(self) -> None:
        """Check the number."""
        check_positive(self, ("unit",))

    def __call__(self, a: Tensor, dt: Tensor) -> Tensor:
        """The command ``(*B, d)`` for a velocity ``(*B, d)``, m/s, over a step of dt, s."""
        return (a * (dt / self.unit)).clamp(-1.0, 1.0)
