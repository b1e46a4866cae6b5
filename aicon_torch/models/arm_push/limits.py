"""Limits of the arm's motion, which are the robot's own: speeds of its tip and of its joints.

They act on the joints by the least motion that takes away what goes beyond. The text has none.
"""

from collections.abc import Sequence

import torch
from torch import Tensor, nn

from aicon_torch.parts.end_effector import EndEffector
from aicon_torch.vectors import shorten

TIP_SPEED = 0.4
"""Largest speed of the tip in the plane, m/s."""

JOINT_SPEED = 4.8
"""Largest norm of the joints' velocities, rad/s."""

SETTLING_TIME = 0.2
"""Least time in which the tip arrives at its height, s: twice that in which the joints follow."""


class ArmLimits(nn.Module):
    """The joint velocities within the limits of the tip and of the joints.

    1. In the plane the tip moves at most at its speed, up and down and in tilt at most at a quarter
       of it, in heading at half of it (in m/s: :class:`aicon_torch.parts.end_effector.ToolPose`).
    2. The tip moves toward its height no faster than it would arrive within the settling time.
    3. No joint is faster than its limit, the direction kept.

    Args:
        end_effector: Of the arm.
        joint_speeds: Largest speed of each joint, rad/s.
    """

    joint_speeds: Tensor

    def __init__(self, end_effector: EndEffector, joint_speeds: Sequence[float]) -> None:
        super().__init__()
        self.end_effector = end_effector
        self.register_buffer("joint_speeds", torch.tensor(joint_speeds, dtype=torch.float64))

    def forward(self, a: Tensor, x_joints: Tensor, x_heights: Tensor) -> Tensor:
        """The velocity of the joints within the limits.

        Args:
            a: The nominal velocity, ``(*B, n)``, rad/s.
            x_joints: Joint angles, ``(*B, n)``, rad.
            x_heights: Height of the tip above where it should be, ``(*B, 1)``, m.

        Returns:
            ``(*B, n)``, rad/s.
        """
        jacobian = self.end_effector.jacobian(x_joints)
        nominal = (jacobian @ a.unsqueeze(-1)).squeeze(-1)

        # The motion of the end effector within its limits, by component.
        planar, rise, tilt, turn = torch.split(nominal, [2, 1, 2, 1], dim=-1)
        planar = shorten(planar, TIP_SPEED)
        rise = shorten(rise, TIP_SPEED / 4)
        tilt = shorten(tilt, TIP_SPEED / 4)
        turn = shorten(turn, TIP_SPEED / 2)
        rise = self._settle(rise, x_heights)

        # The least motion of the joints that takes away the rest.
        motion = torch.cat((planar, rise, tilt, turn), dim=-1)
        a = a - self.end_effector.solve(jacobian, nominal - motion)

        # All joints slow down together, so that the tip keeps its direction.
        excess = (a.abs() / self.joint_speeds.to(a)).amax(-1, keepdim=True)
        return a / excess.clamp(min=1.0)

    def _settle(self, rise: Tensor, x_heights: Tensor) -> Tensor:
        """A vertical speed ``(*B, 1)``, m/s, that arrives at the height not too soon."""
        # On the way to the height no faster than it would arrive; on the way from there it is free.
        arrival = -x_heights / SETTLING_TIME
        slower = torch.minimum(rise.abs(), arrival.abs()) * rise.sign()
        return torch.where(arrival * rise > 0, slower, rise)
