"""A metric of joint motions: how far they take the tip."""

import torch
from torch import Tensor, nn

from aicon_torch.parts.end_effector import EndEffector


class TipMetric(nn.Module):
    """M = JᵀJ + λ²I: δᵀMδ = ‖Jδ‖² + λ²‖δ‖², for a departure δ of the joints' velocities.

    With it the action nearest to a nominal one is the one that takes the tip where the nominal one
    does, as far as the bounds let it: what a joint at its stop cannot do, the others do. J and the
    damping λ are those of the end effector, so that a nominal action J⁺h minimises ‖Ja − h‖² +
    λ²‖a‖², and the nearest action within the bounds does so, too: it solves the damped least
    squares with the bounds in it. Where its turns wait (`turns_within`), M reads the target, too.

    Args:
        end_effector: Of the arm.

    Example:
        >>> metric = TipMetric(end_effector)
        >>> Actuator(6, "rad/s", limit=speeds, metric=metric)
    """

    def __init__(self, end_effector: EndEffector) -> None:
        super().__init__()
        self.end_effector = end_effector

    def forward(self, x_joints: Tensor, x_target: Tensor | None = None) -> Tensor:
        """M at the joint angles ``(*B, n)``, rad; ``(*B, n, n)``, (m/rad)²."""
        frames = self.end_effector.chain.frames(x_joints)
        jacobian = self.end_effector.jacobian_at(frames)
        weights = self.end_effector.weights(self.end_effector.at(frames), x_target)
        if weights is not None:
            jacobian = weights.unsqueeze(-1) * jacobian
        identity = torch.eye(x_joints.shape[-1], dtype=jacobian.dtype, device=jacobian.device)
        return jacobian.mT @ jacobian + self.end_effector.damping**2 * identity
