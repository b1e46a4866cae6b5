"""A dither of the joints that moves the tip in the plane, and nothing else."""

import torch
from torch import Tensor, nn

from aicon_torch.parts.end_effector import EndEffector
from aicon_torch.validation import check_positive


class PlanarDither(nn.Module):
    """D = v J⁺ (e_x, e_y): the joint velocities that move the tip along x and along y.

    What dithers is the tip, and the joints' nullspace, in which nothing would pull them back, stays
    as it is: the ``dither`` of an :class:`aicon_torch.Actuator`.

    Args:
        end_effector: Of the arm.
        speed: v, the largest speed of the tip, m/s.

    Raises:
        OptionError: If the speed is not positive.

    Example:
        >>> dither = PlanarDither(end_effector, speed=0.4)
        >>> Actuator(7, "rad/s", limit=4.8, dither=dither)
    """

    def __init__(self, end_effector: EndEffector, speed: float) -> None:
        super().__init__()
        self.end_effector, self.speed = end_effector, speed
        check_positive(self, ("speed",))

    def forward(self, x_joints: Tensor) -> Tensor:
        """D at the joint angles ``(*B, n)``, rad; ``(*B, n, 2)``, rad/s."""
        jacobian = self.end_effector.jacobian(x_joints)
        lengths = jacobian.shape[-2]

        # v e_x and v e_y: the first two lengths of x_ee are x and y of the tip.
        axes = self.speed * torch.eye(lengths, dtype=jacobian.dtype, device=jacobian.device)
        along_x, along_y = (
            self.end_effector.solve(jacobian, axis.expand(jacobian.shape[:-1])) for axis in axes[:2]
        )
        return torch.stack((along_x, along_y), dim=-1)
