"""What readings say of the object: residuals, which are zero where the two agree."""

from dataclasses import dataclass

import torch
from torch import Tensor

from aicon_torch.differentiation import stop
from aicon_torch.parts.camera import to_world
from aicon_torch.parts.planar import pose_error
from aicon_torch.parts.rigid_object import RigidObject


def keypoints_in_world(z_keypoints: Tensor, x_cam: Tensor) -> Tensor:
    """Keypoints from the frame of the camera into that of the base.

    The camera is held fixed: a reading leads no gradient anywhere.

    Args:
        z_keypoints: In the frame of the camera, ``(*B, 3K)``, m.
        x_cam: The camera, ``(*B, 12)``.

    Returns:
        ``(*B, K, 3)``, m.
    """
    points = z_keypoints.reshape(*z_keypoints.shape[:-1], -1, 3)
    return to_world(stop(x_cam), points)


@dataclass(frozen=True)
class ObservedPose:
    """The residual of the object's pose and of a pose of its frame that is observed.

    Attributes:
        body: The object.
        prior_deviation: Standard deviation of the position at the first reading, m.
        offset: By how much every reading is off, such as of a camera that was moved, ``(3,)``, m
            and rad.
    """

    body: RigidObject
    prior_deviation: float
    offset: Tensor

    def __call__(self, x_pose: Tensor, z_object: Tensor) -> Tensor:
        """x_pose − pose(z_object − offset), ``(*B, 3)``, m and rad, the angle in [−π, π)."""
        return pose_error(x_pose, self._pose(z_object))

    def prior(self, z_object: Tensor) -> tuple[Tensor, Tensor]:
        """Mean ``(*B, 3)`` and covariance ``(3, 3)`` at first: where it is, give or take 1 rad."""
        deviations = z_object.new_tensor((self.prior_deviation, self.prior_deviation, 1.0))
        return self._pose(z_object), torch.diag(deviations**2)

    def _pose(self, z_object: Tensor) -> Tensor:
        """What a reading ``(*B, 3)`` says once it is put right."""
        return self.body.pose_of_frame(z_object - self.offset.to(z_object))


@dataclass(frozen=True)
class SeenKeypoints:
    """The residual of the object's pose and of its keypoints in the image.

    Attributes:
        body: The object.
    """

    body: RigidObject

    def __call__(self, x_pose: Tensor, z_keypoints: Tensor, x_cam: Tensor) -> Tensor:
        """x_pose − registration(z_keypoints), ``(*B, 3)``, m and rad, the angle in [−π, π)."""
        points = keypoints_in_world(z_keypoints, x_cam)
        seen = self.body.registration(points[..., :2])
        return pose_error(x_pose, seen)


def seen_middle(x_pose: Tensor, z_blob: Tensor, x_cam: Tensor) -> Tensor:
    """The residual of the object's position and the middle of what is seen, ``(*B, 2)``, m."""
    middle = keypoints_in_world(z_blob, x_cam)[..., 0, :2]
    return x_pose[..., :2] - middle


def seen_top(x_top: Tensor, z_keypoints: Tensor, x_cam: Tensor) -> Tensor:
    """The residual of the height of the object's top and of its keypoints, ``(*B, 1)``, m."""
    heights = keypoints_in_world(z_keypoints, x_cam)[..., 2]
    return x_top - heights.mean(-1, keepdim=True)
