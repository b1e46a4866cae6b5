"""Motors that take time until they move as they are told."""

import torch
from torch import Tensor

from aicon_torch.differentiation import values_only
from aicon_torch.errors import OptionError
from aicon_torch.estimation import Estimator
from aicon_torch.interconnections import Values


class VelocityLag(Estimator):
    """v_joints: how joints move that follow a velocity command as dv/dt = (a − v)/τ.

    It is the velocity at the end of the last step, v ← v + (1 − e^(−dt/τ)) (a − v). What is
    foreseen is how the joints move when they have followed the command, v = a.

    Args:
        joints: Number of joints, n.
        time_constant: τ, s.

    Raises:
        OptionError: If τ is not positive.
    """

    outputs = ("v_joints",)
    inputs = ("v_joints", "a", "dt")
    is_motion = True

    at_rest: Tensor

    def __init__(self, joints: int, time_constant: float) -> None:
        super().__init__()
        if not time_constant > 0:
            raise OptionError(f"time_constant={time_constant!r}: expected more than 0 s.")
        self.time_constant = time_constant
        self.register_buffer("at_rest", torch.zeros(joints))

    def initial(self, values: Values) -> dict[str, Tensor]:
        """The joints were at rest."""
        return {"v_joints": self.at_rest}

    @values_only
    def update(self, values: Values) -> dict[str, Tensor]:
        """How the joints move after the last action, ``(*B, n)``, rad/s."""
        a, v_joints = values["a"], values["v_joints"]
        steps = values["dt"] / self.time_constant
        return {"v_joints": v_joints + (1 - torch.exp(-steps)) * (a - v_joints)}

    def forward(self, values: Values, output: str) -> Tensor:
        """How the action moves them once it is followed, ``(*B, n)``, rad/s."""
        return values["a"]
