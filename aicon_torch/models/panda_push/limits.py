"""Limits of the arm's motion. They are ours: the text has none.

The arm takes over pushT's limits of the tip near contact. Like them they are bounds on the next displacement that
follow from where things are now, and they act on the joints by the least motion that takes away what goes beyond.
"""

from typing import cast

import torch
from torch import Tensor, nn

from aicon_torch.parts.chain import Kinematics
from aicon_torch.models.panda_push.robot import Robot
from aicon_torch.parts.contact_limits import ContactLimits


class ArmLimits(nn.Module):
    """The joint velocities within the limits of the tip and of the joints.

    1. In the plane the tip moves at most at `max_speed`, and at most at a quarter of it up and down and in tilt, and at
       half of it in heading (all in m/s, see x_ee).
    2. In the plane the tip keeps pushT's limits over the next `horizon`, if there are any.
    3. The tip moves toward its height no faster than it would arrive within `settle`.
    4. No joint is faster than its limit, the direction kept.

    Args:
        robot: The robot.
        kinematics: The chain.
        contact: pushT's limits, in px; None for none.
        scale: px per m.
        max_speed: Largest speed of the tip in the plane, m/s.
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
        self.horizon, self.settle = horizon, settle
        self.limits = (max_speed, max_speed / 4, max_speed / 4, max_speed / 2)
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
        parts = [
            part * (limit / torch.linalg.vector_norm(part, dim=-1, keepdim=True).clamp(min=limit))
            for part, limit in zip(torch.split(motion, [2, 1, 2, 1], dim=-1), self.limits, strict=True)
        ]
        wanted = torch.cat(parts, dim=-1)
        if self.contact is not None:
            wish = self.scale * wanted[..., :2]
            allowed = self.contact(
                wish, x_pusher, torch.zeros_like(wish), x_contact, x_side, x_obj, x_target, self.horizon
            )
            wanted[..., :2] = allowed / self.scale
        needed = -x_heights / (self.scale * self.settle)  # m/s
        rise = wanted[..., 2:3]
        settled = torch.where(needed * rise > 0, torch.minimum(rise.abs(), needed.abs()) * rise.sign(), rise)
        wanted[..., 2:3] = settled
        a = a - self.kinematics.solve(jacobian, motion - wanted)
        fastest = (a.abs() / cast(Tensor, self.speed).to(a)).amax(-1, keepdim=True)
        return a / fastest.clamp(min=1.0)
