"""Robots that do not follow a command at once."""

from dataclasses import dataclass

import torch
from torch import Tensor

from aicon_torch.validation import check_positive


@dataclass(frozen=True)
class Lag:
    """A robot whose velocity follows what it is told with the time constant τ: dv/dt = (a − v)/τ.

    Attributes:
        time: τ, s.

    Raises:
        OptionError: If it is not positive.

    Example:
        >>> lag = Lag(0.1)  # in a graph with a reading or an estimate "v_robot"
        >>> Deterministic("x_rob", lag.displacement, is_motion=True)
        >>> Policy(model, law=Foresight(horizon=0.2))  # beyond the lag
    """

    time: float

    def __post_init__(self) -> None:
        """Check the number."""
        check_positive(self, ("time",))

    def displacement(self, a: Tensor, v_robot: Tensor, dt: Tensor) -> Tensor:
        """How far it gets while it is told a: a dt − (a − v) τ (1 − e^(−dt/τ)), ``(*B, d)``, m.

        Args:
            a: What it is told, ``(*B, d)``, m/s.
            v_robot: The velocity now, ``(*B, d)``, m/s.
            dt: For how long, s.
        """
        behind = self.time * (1.0 - torch.exp(-dt / self.time))
        return a * dt - (a - v_robot) * behind

    def velocity(self, a: Tensor, v_robot: Tensor, dt: Tensor) -> Tensor:
        """The velocity after that time: a − (a − v) e^(−dt/τ), ``(*B, d)``, m/s.

        Args:
            a: What it is told, ``(*B, d)``, m/s.
            v_robot: The velocity now, ``(*B, d)``, m/s.
            dt: For how long, s.
        """
        return a - (a - v_robot) * torch.exp(-dt / self.time)
