"""An offset of all keypoints, such as of a camera that was moved: what touching an object tells.

Keypoints that are all off by the same look like an object somewhere else. But an object moves only
while it is touched: then the gap between where the pusher is and where the object is seen tells
the offset along the normal of that side, and pushes on other sides tell the rest.
"""

from collections.abc import Callable
from dataclasses import dataclass

import torch
from torch import Tensor
from torch.nn.functional import pad

from aicon_torch.parts.contact import nearest_point
from aicon_torch.parts.planar import as_points, norm, pose_error
from aicon_torch.parts.rigid_object import RigidObject
from aicon_torch.vectors import unit

DEPTH_SHARE = 0.05
"""Depth to which a pusher gets into an object, by how far the object moves in the step."""

GATE = 2.0
"""Gap at which the pusher has left the object again, in standard deviations."""

NO_TOUCH = 1e6
"""Variance of the gap where nothing is touched, in that of a touch."""


@dataclass(frozen=True)
class KeypointOffset:
    """What a pusher that touches an object tells of x_offset = (offset, last pose), ``(*B, 5)``.

    The offset (x, y) is in m; the last pose (x, y, θ), m and rad, is the one that the last reading
    showed, so that a motion can be told from rest. With the pusher's position p and radius r, and
    the point c of the object as it is seen that is nearest to p + offset,

    gap = ‖c − (p + offset)‖ − r

    is zero where the object has moved, and nowhere less than zero.

    Attributes:
        body: The object.
        radius: Radius of the pusher, m.
        deviation: Standard deviation of the gap where the object is touched, m.
        least_motion: Motion of a keypoint from which on it is no noise, m.
    """

    body: RigidObject
    radius: float
    deviation: float
    least_motion: float

    def prior(self, deviation: float) -> Callable[[Tensor], tuple[Tensor, Tensor]]:
        """No offset, and the first pose; by the standard deviation of the offset, m."""

        def first(z_keypoints: Tensor) -> tuple[Tensor, Tensor]:
            # The offset, unknown, stands before the pose, which is taken as it is read.
            mean = pad(self.body.registration(as_points(z_keypoints)), (2, 0))
            variances = (deviation**2, deviation**2, 0.0, 0.0, 0.0)
            return mean, torch.diag(z_keypoints.new_tensor(variances))

        return first

    def gap(self, x_offset: Tensor, z_keypoints: Tensor, z_pusher: Tensor) -> Tensor:
        """The gap ``(*B, 1)``, m, with keypoints ``(*B, 2K)`` and a pusher at ``(*B, 2)``, m."""
        away = self._from_object(x_offset, z_keypoints, z_pusher)
        return norm(away).unsqueeze(-1) - self.radius

    def gap_jacobian(self, x_offset: Tensor, z_keypoints: Tensor, z_pusher: Tensor) -> Tensor:
        """∂gap/∂x_offset, the unit vector away from the object and zeros, ``(*B, 1, 5)``."""
        away = unit(self._from_object(x_offset, z_keypoints, z_pusher))
        return pad(away, (0, 3)).unsqueeze(-2)

    def variance(
        self, x_offset: Tensor, P_offset: Tensor, z_keypoints: Tensor, z_pusher: Tensor
    ) -> Tensor:
        """The variance of the gap, ``(*B, 1)``, m²: of no use where it says nothing.

        Args:
            x_offset: The offset before the reading, and the pose that was read last, ``(*B, 5)``.
            P_offset: Its covariance, ``(*B, 5, 5)``.
            z_keypoints: The reading, ``(*B, 2K)``, m.
            z_pusher: Where the pusher is, ``(*B, 2)``, m.
        """
        # How far has the object moved, and how deep may the pusher be in it?
        before = self.body.keypoints_at(x_offset[..., 2:])
        motion = (as_points(z_keypoints) - before).abs().amax((-1, -2)).unsqueeze(-1)
        touch = (self.deviation + DEPTH_SHARE * motion).square()

        # It is touched if it moved and the pusher has not left it since, or where they overlap.
        gap = self.gap(x_offset, z_keypoints, z_pusher)
        slope = self.gap_jacobian(x_offset, z_keypoints, z_pusher)
        spread = (slope @ P_offset @ slope.mT).squeeze(-1) + touch
        is_pushed = (motion > self.least_motion) & (gap < GATE * spread.sqrt())
        is_touched = is_pushed | (gap < -self.deviation)
        return torch.where(is_touched, touch, NO_TOUCH * touch)

    def last_pose(self, x_offset: Tensor, z_keypoints: Tensor) -> Tensor:
        """The residual of the last pose and of the one that is read, ``(*B, 3)``, m and rad."""
        seen = self.body.registration(as_points(z_keypoints))
        return pose_error(x_offset[..., 2:], seen)

    def _from_object(self, x_offset: Tensor, z_keypoints: Tensor, z_pusher: Tensor) -> Tensor:
        """From the nearest point of the object to the pusher, ``(*B, 2)``, m."""
        pusher = z_pusher + x_offset[..., :2]
        point, _ = nearest_point(pusher, self.body.sides(as_points(z_keypoints)))
        return pusher - point
