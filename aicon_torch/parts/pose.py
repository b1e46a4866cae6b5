"""Where the object is: predicted from what the pusher did, corrected by registration."""

from dataclasses import dataclass

import torch
from torch import Tensor

from aicon_torch.differentiation import is_nowhere, stop
from aicon_torch.parts.contact import nearest_point
from aicon_torch.parts.contact_dynamics import ContactDynamics
from aicon_torch.parts.planar import as_points, cross, norm, pose_error, quarter_turn
from aicon_torch.parts.rigid_object import RigidObject
from aicon_torch.validation import check_not_negative, check_positive
from aicon_torch.vectors import constants

NO_FORCE = 1e-12
"""Motion along the normal that counts as none, m."""


@dataclass(frozen=True)
class PoseMotion:
    """The pose after the last action: pushed as far as the pusher went beyond the nearest side.

    The pusher's way is followed part by part. With the gap to the nearest side before a part, its
    motion d and the unit vector n towards the side, the push is max(d·n − max(gap, 0), 0), and the
    object moves by as much of its response (:meth:`ContactDynamics.response`) along the force.

    The force f at the contact is A⁻¹d, which makes it stick, A = I + wwᵀ/r² with w across the arm
    of the force and r the radius of gyration, or at the edge of the cone of friction where that is
    within: f ∥ n + clip(fₜ/fₙ, ±μ) t.

    Its Jacobian by x_pose is the identity.

    Attributes:
        dynamics: What a push does.
        radius: Radius of the pusher, m.
        friction: μ between pusher and object; 0 pushes along the normal.

    Raises:
        OptionError: If a number is negative.
    """

    dynamics: ContactDynamics
    radius: float
    friction: float = 0.0

    def __post_init__(self) -> None:
        """Check the numbers."""
        check_not_negative(self, ("radius", "friction"))

    def __call__(self, x_pose: Tensor, x_pusher: Tensor, d_pusher: Tensor) -> Tensor:
        """The pose (x, y, θ).

        Args:
            x_pose: The pose before, ``(*B, 3)``, m and rad.
            x_pusher: Where the pusher has arrived, ``(*B, 2)``, m.
            d_pusher: Its displacements after each part of its way, ``(*B, 2n)``, m.

        Returns:
            ``(*B, 3)``, m and rad.
        """
        # What moved the object is past, and what will move it is the contact model's matter; how a
        # push depends on the pose is of second order. So the belief moves as it is, and no gradient
        # leaves through the push.
        way, pose = as_points(stop(d_pusher)), stop(x_pose)

        # The pusher has arrived; its displacements count from where the step began.
        start = stop(x_pusher) - way[..., -1, :]

        moved = torch.zeros_like(pose)
        before = torch.zeros_like(start)
        for after in way.unbind(-2):
            moved = moved + self._push(pose + moved, start + before, after - before)
            before = after
        return x_pose + moved

    def _push(self, pose: Tensor, pusher: Tensor, motion: Tensor) -> Tensor:
        """The object's motion ``(*B, 3)`` while the pusher makes a short motion ``(*B, 2)``."""
        # The nearest side before the motion.
        body = self.dynamics.body
        point, distance = nearest_point(pusher, body.sides(body.keypoints_at(pose)))
        gap = distance.squeeze(-1) - self.radius

        # How far the pusher went beyond it.
        normal = (point - pusher) / (gap + self.radius).unsqueeze(-1)
        push = ((motion * normal).sum(-1) - gap.clamp(min=0.0)).clamp(min=0.0)
        if is_nowhere(push != 0):
            return torch.zeros_like(pose)

        # What that does.
        if isinstance(self.friction, int | float) and self.friction == 0:
            response = self.dynamics.response(pose, point.unsqueeze(-2), normal.unsqueeze(-2))
            return push.unsqueeze(-1) * response.squeeze(-2)
        return push.unsqueeze(-1) * self._response(point - pose[..., :2], normal, motion)

    def _response(self, arm: Tensor, normal: Tensor, motion: Tensor) -> Tensor:
        """Motion of the object by each metre of a push with friction, ``(*B, 3)``.

        Args:
            arm: From its centre to the contact, ``(*B, 2)``, m.
            normal: Unit vector into the object there, ``(*B, 2)``.
            motion: d of the pusher, ``(*B, 2)``, m.
        """
        square = self.dynamics.body.radius_of_gyration**2
        across, along_side = quarter_turn(arm), quarter_turn(normal)

        # The force that makes the contact stick, A⁻¹d, and how steep it is.
        share = cross(arm, motion) / (square + (arm * arm).sum(-1))
        force = motion - share.unsqueeze(-1) * across
        along = (force * normal).sum(-1).clamp(min=NO_FORCE)
        slope = ((force * along_side).sum(-1) / along).clamp(-self.friction, self.friction)

        # What it does, so that the contact goes along the normal as far as the pusher.
        direction = normal + slope.unsqueeze(-1) * along_side
        turn = cross(arm, direction) / square
        speed = 1 + turn * cross(arm, normal)
        return torch.cat((direction, turn.unsqueeze(-1)), dim=-1) / speed.unsqueeze(-1)


@dataclass(frozen=True)
class PushNoise:
    """Variances of a pose that a step adds: σ² = σ₀² + (κ d)², where a push has moved it by d.

    An object at rest stays, and what a push does is known to a share κ of it.

    Attributes:
        motion: What a push does.
        rest: σ₀, m.
        share: κ.
    """

    motion: PoseMotion
    rest: float
    share: float

    def __call__(self, x_pose: Tensor, x_pusher: Tensor, d_pusher: Tensor) -> Tensor:
        """The variances ``(*B, 3)``, m² and rad²; the arguments are those of the motion."""
        gyration = self.motion.dynamics.body.radius_of_gyration
        moved = stop(self.motion(x_pose, x_pusher, d_pusher) - x_pose)

        # A turn as the way of a point at the radius of gyration, m, and its variance back by it.
        turned = gyration * moved[..., 2:]
        square = (moved[..., :2] ** 2).sum(-1, keepdim=True) + turned**2
        variance = self.rest**2 + self.share**2 * square
        return torch.cat((variance, variance, variance / gyration**2), dim=-1)


def resting_pose(x_pose: Tensor) -> Tensor:
    """The pose where it was last seen, ``(*B, 3)``."""
    return x_pose


@dataclass(frozen=True)
class KeypointRegistration:
    """The residual x_pose − registration(z_keypoints) of a pose and of the keypoints seen.

    Attributes:
        body: Whose keypoints they are.
        prior_deviation: Standard deviation of the pose at the first reading, m; its rotation moves
            a point at the radius of gyration by as much.
    """

    body: RigidObject
    prior_deviation: float = 0.01

    def __call__(self, x_pose: Tensor, z_keypoints: Tensor) -> Tensor:
        """The residual.

        Args:
            x_pose: (x, y, θ), ``(*B, 3)``, m and rad.
            z_keypoints: ``(*B, 2K)``, m.

        Returns:
            ``(*B, 3)``, m and rad, the angle in [−π, π).
        """
        return pose_error(x_pose, self.observed_pose(z_keypoints))

    def observed_pose(self, z_keypoints: Tensor) -> Tensor:
        """The pose ``(*B, 3)``, m and rad, that a reading ``(*B, 2K)``, m, shows."""
        return self.body.registration(as_points(z_keypoints))

    def prior(self, z_keypoints: Tensor) -> tuple[Tensor, Tensor]:
        """Mean ``(*B, 3)`` and covariance ``(3, 3)`` at first: where the first reading shows it."""
        rotation_deviation = self.prior_deviation / self.body.radius_of_gyration
        each = (self.prior_deviation, self.prior_deviation, rotation_deviation)
        deviations = constants(each, z_keypoints)
        return self.observed_pose(z_keypoints), torch.diag(deviations**2)

    def variances(self, noise: float) -> tuple[float, float, float]:
        """Variances of a registered pose by those of its keypoints, in the body frame.

        The position is known best at the mean of the keypoints; from there a rotation swings the
        centre of mass.

        Args:
            noise: Standard deviation of each coordinate of a keypoint, m.

        Returns:
            Of x, y and θ, m², m² and rad².
        """
        # σ²/Σ rᵢ² for the rotation, with arms rᵢ from the mean of the keypoints, and σ²/K for it.
        mean = self.body.keypoints.mean(0)
        spread = self.body.keypoints - mean
        rotation = noise**2 / float((spread * spread).sum())

        x, y = (noise**2 / len(spread) + rotation * mean.flip(0) ** 2).tolist()
        return x, y, rotation


@dataclass(frozen=True)
class PoseDistance:
    """g = ‖(Δx, Δy, LΔθ)‖: how far the object is from its target.

    Attributes:
        rotation_length: L, m: a rotation by one rad counts as much as a translation by L.

    Raises:
        OptionError: If the length is not positive.
    """

    rotation_length: float

    def __post_init__(self) -> None:
        """Check the length."""
        check_positive(self, ("rotation_length",))

    def __call__(self, x_obj: Tensor, x_target: Tensor) -> Tensor:
        """The distance ``(*B,)``, m, of two poses ``(*B, 3)``, m and rad."""
        return norm(pose_error(x_obj, x_target, self.rotation_length))


@dataclass(frozen=True)
class FixedTarget:
    """x_target: a target that does not depend on a reading.

    Attributes:
        pose: Centre of mass and orientation (x, y, θ), ``(3,)``, m and rad.
    """

    pose: Tensor

    def __call__(self, x_pose: Tensor) -> Tensor:
        """The target ``(*B, 3)``; the object's pose ``(*B, 3)`` tells the batch."""
        return self.pose.to(x_pose).expand_as(x_pose)
