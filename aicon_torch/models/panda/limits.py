"""Limits of the arm's motion. They are ours: the text has none.

The arm takes over pushT's limits of the tip near contact. Like them they are bounds on the next displacement that
follow from where things are now, and they act on the joints by the least motion that takes away what goes beyond.
"""

from typing import cast

import torch
from torch import Tensor, nn

from aicon_torch.models.panda.kinematics import Kinematics
from aicon_torch.models.panda.robot import Robot
from aicon_torch.models.pusht.limits import ContactLimits


class ArmLimits(nn.Module):
    """The joint velocities within the limits of the tip and of the joints.

    1. The speed of x_ee is at most `max_speed`, the direction in joint space kept.
    2. In the plane the tip keeps pushT's limits over the next `horizon`, if there are any.
    3. The tip moves toward its height no faster than it would arrive within `settle`.
    4. No joint is faster than its limit, the direction kept.

    Args:
        robot: The robot.
        kinematics: The chain.
        contact: pushT's limits, in px; None for none.
        scale: px per m.
        max_speed: Largest speed of x_ee, m/s.
        horizon: Time over which pushT's limits hold, s.
        settle: Least time to arrive at a height, s.
    """

    def __init__(
        self,
        robot: Robot,
        kinematics: Kinematics,
        contact: ContactLimits | None,
        scale: float,
        max_speed: float,
        horizon: float,
        settle: float,
    ) -> None:
        super().__init__()
        self.kinematics, self.contact, self.scale = kinematics, contact, scale
        self.max_speed, self.horizon, self.settle = max_speed, horizon, settle
        self.register_buffer("speed", torch.tensor(robot.speed, dtype=torch.float64))

    def forward(
        self,
        a: Tensor,
        x_joints: Tensor,
        x_pusher: Tensor,
        x_contact: Tensor,
        x_side: Tensor,
        x_obj: Tensor,
        x_target: Tensor,
        x_heights: Tensor,
    ) -> Tensor:
        """The velocity of the joints within the limits, ``(*B, 7)``, rad/s."""
        jacobian = self.kinematics.jacobian(self.kinematics.frames(x_joints))
        motion = (jacobian @ a.unsqueeze(-1)).squeeze(-1)
        speed = torch.linalg.vector_norm(motion, dim=-1, keepdim=True)
        share = (self.max_speed / speed.clamp(min=1e-12)).clamp(max=1.0)
        a, motion = a * share, motion * share
        excess = torch.zeros_like(motion)
        if self.contact is not None:
            wish = self.scale * motion[..., :2]
            allowed = self.contact(
                wish, x_pusher, torch.zeros_like(wish), x_contact, x_side, x_obj, x_target, self.horizon
            )
            excess[..., :2] = (wish - allowed) / self.scale
        needed = -x_heights / (self.scale * self.settle)  # m/s
        rise = motion[..., 2:3]
        settled = torch.where(needed * rise > 0, torch.minimum(rise.abs(), needed.abs()) * rise.sign(), rise)
        excess[..., 2:3] = rise - settled
        a = a - self.kinematics.solve(jacobian, excess)
        fastest = (a.abs() / cast(Tensor, self.speed).to(a)).amax(-1, keepdim=True)
        return a / fastest.clamp(min=1.0)
