"""Robots on wheels, by the motion of a point ahead of them that can go in any direction.

A wheel does not move sideways, so no action of the moment brings the middle of the axle to the
left, and the gradient of a goal there has nothing to say of turning. A point ahead of the axle goes
left when the robot turns left. How it moves in a step, in the robot's own axes (x ahead, y to the
left),

    x_rob = (s, ℓ θ),

with the way s and the turn θ, is where gradients meet; ℓ follows from the robot.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import torch
from torch import Tensor

from aicon_torch.estimation import EKF, Measurement, covariance_name
from aicon_torch.interconnections import Interconnection
from aicon_torch.parts.planar import pose_error, rotate
from aicon_torch.parts.prior import ReadingPrior, first_belief
from aicon_torch.validation import check_positive


class Wheels:
    """What robots on wheels have in common; poses are those of the middle of the fixed axle."""

    @property
    def ahead(self) -> float:
        """ℓ, how far ahead of the axle the point is, m."""
        raise NotImplementedError

    def motion(self, a: Tensor, dt: Tensor) -> Tensor:
        """x_rob = (s, ℓ θ), how the point ahead moves in a step, ``(*B, 2)``, m.

        Args:
            a: The action, ``(*B, 2)``.
            dt: Duration of the step, s.
        """
        v, turn_rate = self.twist(a).unbind(-1)
        return torch.stack((v, self.ahead * turn_rate), dim=-1) * dt

    def twist(self, a: Tensor) -> Tensor:
        """(v, ω), the speed of the axle and the rate of turning, ``(*B, 2)``, m/s and rad/s.

        It is an actuator's ``command`` for a robot that takes these two.

        Args:
            a: The action, ``(*B, 2)``.
        """
        raise NotImplementedError

    def moved(self, x_pose: Tensor, x_rob: Tensor) -> Tensor:
        """The pose after a step: along the chord of an arc.

        Args:
            x_pose: (x, y, θ) in the world, ``(*B, 3)``, m and rad.
            x_rob: (s, ℓ θ), ``(*B, 2)``, m.

        Returns:
            ``(*B, 3)``, m and rad; a chord is taken to be as long as its arc, to θ²/24 of it.
        """
        turn = self._turn(x_rob)
        place = x_pose[..., :2] + rotate(self._chord(x_rob), x_pose[..., 2])
        return torch.cat((place, x_pose[..., 2:] + turn.unsqueeze(-1)), dim=-1)

    def point_ahead(self, x_pose: Tensor) -> Tensor:
        """Where the point ahead is in the world, ``(*B, 2)``, m.

        Args:
            x_pose: (x, y, θ), ``(*B, 3)``, m and rad.
        """
        heading = x_pose[..., 2:]
        way = torch.cat((torch.cos(heading), torch.sin(heading)), dim=-1)
        return x_pose[..., :2] + self.ahead * way

    def seen_after(self, p: Tensor, x_rob: Tensor) -> Tensor:
        """Where a point that rests is seen after a step, in the robot's axes of then.

        Args:
            p: (x, y) in the robot's axes, from the middle of the axle, ``(*B, 2)``, m.
            x_rob: (s, ℓ θ), ``(*B, 2)``, m.

        Returns:
            R(−θ) (p − chord), ``(*B, 2)``, m.
        """
        return rotate(p - self._chord(x_rob), -self._turn(x_rob))

    def axes_after(self, x_rob: Tensor) -> Tensor:
        """R(−θ), how the robot's axes see after a step what they saw before, ``(*B, 2, 2)``."""
        turn = self._turn(x_rob)
        cos, sin = torch.cos(turn), torch.sin(turn)
        new_x, new_y = torch.stack((cos, sin), dim=-1), torch.stack((-sin, cos), dim=-1)
        return torch.stack((new_x, new_y), dim=-2)

    def variances(self, p: Tensor, deviation: float) -> Tensor:
        """What an error of x_rob makes of a point that is seen: σ² (1 + y²/ℓ², 1 + x²/ℓ²).

        Args:
            p: (x, y) in the robot's axes, ``(*B, 2)``, m.
            deviation: σ, standard deviation of each component of x_rob, m.

        Returns:
            Variances, ``(*B, 2)``, m².
        """
        lever = p.flip(-1) / self.ahead
        return deviation**2 * (1.0 + lever * lever)

    def pose_estimator(
        self,
        name: str,
        reading: str,
        noise: Sequence[float],
        motion_noise: float,
        motion: str = "x_rob",
    ) -> EKF:
        """A filter of the pose in the world, which something measures, such as a camera above.

        Args:
            name: Of the estimate ``(*B, 3)``, m and rad, such as ``"x_pose"``; its covariance is
                ``"P_pose"``.
            reading: The sensor of (x, y, θ), ``(*B, 3)``, m and rad.
            noise: Standard deviations of its components, m, m and rad.
            motion_noise: σ, standard deviation of each component of ``motion`` in a step, m.
            motion: The quantity x_rob.
        """
        variances = [deviation**2 for deviation in noise]
        agreement = Interconnection(pose_error, [name, reading])
        return EKF(
            name,
            covariance_name(name),
            predict=Interconnection(self.moved, [name, motion]),
            # The turn is ℓ θ through ℓ.
            noise=(motion_noise**2, motion_noise**2, (motion_noise / self.ahead) ** 2),
            initial=first_belief(ReadingPrior(tuple(variances)), reading),
            size=3,
            correct=[Measurement(agreement, variances, size=3)],
        )

    def _turn(self, x_rob: Tensor) -> Tensor:
        """θ, ``(*B,)``, rad."""
        return x_rob[..., 1] / self.ahead

    def _chord(self, x_rob: Tensor) -> Tensor:
        """The way of the axle in the axes of before, ``(*B, 2)``, m."""
        # The chord of an arc has turned by half as much as the arc has at its end.
        half = self._turn(x_rob) / 2
        return x_rob[..., :1] * torch.stack((torch.cos(half), torch.sin(half)), dim=-1)


@dataclass(frozen=True)
class DifferentialDrive(Wheels):
    """Two wheels side by side, each with a motor: the action is (left, right), m/s.

    v = (left + right)/2, ω = (right − left)/w. With ℓ = w/2 the point ahead moves as fast to the
    side as it does ahead, and x_rob is the action but for a rotation and a factor.

    Attributes:
        track: w, from wheel to wheel, m.

    Raises:
        OptionError: If it is not positive.

    Example:
        >>> drive = DifferentialDrive(track=0.3)
        >>> Actuator(2, "m/s", limit=(0.5, 0.5))  # with command=drive.twist it is sent (v, ω)
        >>> Deterministic("x_rob", drive.motion, is_motion=True)
    """

    track: float

    def __post_init__(self) -> None:
        """Check the number."""
        check_positive(self, ("track",))

    @property
    def ahead(self) -> float:
        """ℓ = w/2, m."""
        return self.track / 2

    def twist(self, a: Tensor) -> Tensor:
        """(v, ω), ``(*B, 2)``, m/s and rad/s, of (left, right) ``(*B, 2)``, m/s."""
        left, right = a.unbind(-1)
        return torch.stack(((left + right) / 2, (right - left) / self.track), dim=-1)


@dataclass(frozen=True)
class Bicycle(Wheels):
    """A wheel that steers ahead of a fixed one, as cars have them: the action is (v, δ).

    v is the speed of the fixed axle, m/s, and δ the angle of steering, rad: ω = v tan(δ)/L. With
    ℓ = L the point ahead is the middle of the wheel that steers. It moves ahead and back within
    the largest angle, less than π/2, which the actuator's limit tells; so a goal beside it takes
    some turns.

    Attributes:
        wheelbase: L, from axle to axle, m.

    Raises:
        OptionError: If it is not positive.

    Example:
        >>> car = Bicycle(wheelbase=0.3)
        >>> Actuator(2, "m/s and rad", limit=(0.5, 0.6))
        >>> Deterministic("x_rob", car.motion, is_motion=True)
    """

    wheelbase: float

    def __post_init__(self) -> None:
        """Check the number."""
        check_positive(self, ("wheelbase",))

    @property
    def ahead(self) -> float:
        """ℓ = L, m."""
        return self.wheelbase

    def twist(self, a: Tensor) -> Tensor:
        """(v, ω), ``(*B, 2)``, m/s and rad/s, of (v, δ) ``(*B, 2)``, m/s and rad."""
        v, angle = a.unbind(-1)
        return torch.stack((v, v * torch.tan(angle) / self.wheelbase), dim=-1)
