"""A limit on the speed of an end effector."""

import torch
from torch import Tensor, nn

from aicon_torch.parts.end_effector import EndEffector


class SpeedLimit(nn.Module):
    """a ← a·min(1, v_max/‖J_p a‖): the tip is never faster than v_max, whatever the joints may do.

    The action is shortened as a whole, so that its direction stays.

    Args:
        end_effector: Of the arm; the first three components of its x_ee are the tip's position.
        speed: v_max, m/s.

    Example:
        >>> Actuator(7, "rad/s", limit=speeds, constraints=[SpeedLimit(end_effector, speed=0.25)])
    """

    def __init__(self, end_effector: EndEffector, speed: float) -> None:
        super().__init__()
        self.end_effector, self.speed = end_effector, speed

    def forward(self, a: Tensor, x_joints: Tensor) -> Tensor:
        """The velocity ``(*B, n)`` within it, rad/s, of joints at the angles ``(*B, n)``, rad."""
        jacobian = self.end_effector.jacobian(x_joints)[..., :3, :]
        velocity = (jacobian @ a.unsqueeze(-1)).squeeze(-1)
        speed = torch.linalg.vector_norm(velocity, dim=-1, keepdim=True)
        shortened: Tensor = a * (self.speed / speed.clamp(min=self.speed))
        return shortened
