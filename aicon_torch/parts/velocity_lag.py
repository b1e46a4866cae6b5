"""Motors that take time until they move as they are told."""

import torch
from torch import Tensor

from aicon_torch.differentiation import values_only
from aicon_torch.estimation import Estimator
from aicon_torch.interconnections import Values
from aicon_torch.validation import check_count, check_positive


class VelocityLag(Estimator):
    """v_joints: how joints move that follow a velocity command as dv/dt = (a − v)/τ.

    It is the velocity at the end of the last step, v ← v + (1 − e^(−dt/τ)) (a − v). What is
    foreseen is how the joints move when they have followed the command, v = a.

    Args:
        joints: Number of joints, n.
        time_constant: τ, s.

    Raises:
        OptionError: If there is no joint, or τ is not positive.
    """

    outputs = ("v_joints",)
    inputs = ("v_joints", "a", "dt")
    is_motion = True

    at_rest: Tensor

    def __init__(self, joints: int, time_constant: float) -> None:
        super().__init__()
        self.joints, self.time_constant = joints, time_constant
        check_count(self, ("joints",), "number of joints", least=1)
        check_positive(self, ("time_constant",))
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
