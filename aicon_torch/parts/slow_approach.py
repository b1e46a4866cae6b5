"""A speed limit near the object: simpler than limits of each contact."""

from dataclasses import dataclass

import torch
from torch import Tensor

from aicon_torch.parts.planar import norm, pose_error

LEAST_SHARE = 0.1
"""Share of the step near contact that is left at the goal."""


@dataclass(frozen=True)
class SlowApproach:
    """Fast in the open, slow near contact, and slower near the goal.

    |a|·dt ≤ (1 − p) s_open + p s_near clip(g/g₀, 0.1, 1) with p = exp(−max(gap, 0)/ℓ) and the
    distance g to the goal.

    Attributes:
        rotation_length: L of the pose error, m.
        radius: Radius of the pusher, m.
        open_step: s_open, m.
        near_step: s_near, m.
        near_length: ℓ, m.
        slow_distance: g₀, m.
    """

    rotation_length: float
    radius: float
    open_step: float
    near_step: float
    near_length: float
    slow_distance: float

    def __call__(
        self,
        a: Tensor,
        x_pusher: Tensor,
        x_contact: Tensor,
        x_obj: Tensor,
        x_target: Tensor,
        dt: float,
    ) -> Tensor:
        """The velocity at the limit of speed or below.

        Args:
            a: The velocity that is wished for, ``(*B, 2)``, m/s.
            x_pusher: Centre of the pusher, ``(*B, 2)``, m.
            x_contact: The closest point of each side, ``(*B, N, 2)``, m.
            x_obj: The object's pose, ``(*B, 3)``, m and rad.
            x_target: Its target, likewise.
            dt: Duration of the step, s.

        Returns:
            ``(*B, 2)``, m/s, in the same direction.
        """
        gap = norm(x_contact - x_pusher.unsqueeze(-2)).amin(-1) - self.radius
        near = torch.exp(-gap.clamp(min=0.0) / self.near_length)

        distance = norm(pose_error(x_obj, x_target, self.rotation_length))
        share = (distance / self.slow_distance).clamp(LEAST_SHARE, 1.0)
        limit = ((1 - near) * self.open_step + near * self.near_step * share) / dt

        speed = norm(a).clamp(min=1e-12)
        return a * (limit / speed).clamp(max=1.0).unsqueeze(-1)
