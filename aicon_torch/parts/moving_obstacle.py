"""An obstacle that may move, seen by range and bearing: where it is, and where it will be."""

from dataclasses import dataclass

import torch
from torch import Tensor

from aicon_torch.estimation import EKF, Measurement, covariance_name
from aicon_torch.interconnections import Interconnection
from aicon_torch.parts.contact import likelihood_across
from aicon_torch.parts.landmark import bearing_jacobian, bearing_residual
from aicon_torch.parts.obstacle import drift, moved_evenly
from aicon_torch.parts.planar import norm, rotate
from aicon_torch.parts.prior import first_belief
from aicon_torch.parts.self_collision import segment_distance
from aicon_torch.parts.wheels import Wheels
from aicon_torch.validation import check_not_negative, check_positive
from aicon_torch.vectors import constants, unit


@dataclass(frozen=True)
class MovingObstacle:
    """An obstacle that moves evenly, as an estimator and a cost of any graph.

    The belief N(x, P) of x = (p, v), its position relative to the robot and its velocity, moves by
    itself and against the robot,

        p⁻ = p + v dt − x_rob,   v⁻ = v + N(0, (σ dt)²),

    in the axes of the world, or in those of a robot on wheels, which turn. It is corrected by range
    and bearing, (‖p‖, atan2(p_y, p_x)) − z = 0.

    Attributes:
        name: Of the estimate, ``(*B, 4)``, m and m/s, such as ``"x_person"``; its covariance is
            ``"P_person"``.
        reading: The sensor of range and bearing, ``(*B, 2)``, m and rad.
        range_noise: Standard deviation of the range, m.
        bearing_noise: Standard deviation of the bearing, rad.
        motion_noise: Standard deviation of what the robot moves in a step besides ``motion``, m.
        dt: Time step in which the velocity changes, s; the motion takes as long as a clock tells.
        acceleration: σ, m/s².
        speed: Standard deviation of each component of the velocity before the first motion, m/s.
        motion: The quantity that says how the robot has moved in a step, ``(*B, 2)``, m.
        wheels: Of a robot on wheels, whose axes then are those of x and of the readings.

    Raises:
        OptionError: If a number is not what it may be.

    Example:
        >>> noise = {"range_noise": 0.02, "bearing_noise": 0.02, "motion_noise": 0.0005}
        >>> person = MovingObstacle("x_person", "z_person", **noise, dt=0.05, wheels=drive)
        >>> estimators = [Deterministic("x_rob", drive.motion, is_motion=True), person.estimator()]
        >>> Goal("avoid", person.collision_likelihood(radius=0.5, length=0.1, horizon=2.0))
    """

    name: str
    reading: str
    range_noise: float
    bearing_noise: float
    motion_noise: float
    dt: float
    acceleration: float = 0.5
    speed: float = 1.0
    motion: str = "x_rob"
    wheels: Wheels | None = None

    def __post_init__(self) -> None:
        """Check the numbers."""
        check_positive(self, ("range_noise", "bearing_noise", "dt", "acceleration", "speed"))
        check_not_negative(self, ("motion_noise",))

    @property
    def covariance(self) -> str:
        """Name of P, ``(*B, 4, 4)``."""
        return covariance_name(self.name)

    def estimator(self) -> EKF:
        """The filter of its position and velocity."""
        moved = Interconnection(self._transition, [self.motion, "dt"])
        inputs = [self.name, self.motion, "dt"]
        prior = RangeBearingPrior(self.range_noise, self.bearing_noise, self.speed)
        return EKF(
            self.name,
            self.covariance,
            predict=Interconnection(self._moved, inputs, **{self.name: moved}),
            noise=Interconnection(self._drift, [self.name]),
            initial=first_belief(prior, self.reading),
            size=4,
            correct=[self._measurement()],
        )

    def collision_likelihood(self, radius: float, length: float, horizon: float) -> Interconnection:
        """The cost exp(−d/ℓ), ``(*B,)``, where d is the least gap within a while.

        Args:
            radius: Of the obstacle and the robot together, m. A robot on wheels counts from the
                middle of its axle to the point ahead.
            length: ℓ, m.
            horizon: For how long it is followed on its way, s, while the robot stands; 0 for the
                gap of now.

        Raises:
            OptionError: If the length is not positive, or another number negative.
        """
        ahead = 0.0 if self.wheels is None else self.wheels.ahead
        gap = GapToCome(radius, horizon, ahead)
        return Interconnection(CollisionToCome(gap, length), [self.name])

    def _moved(self, x: Tensor, x_rob: Tensor, dt: Tensor) -> Tensor:
        """Position and velocity after a step, ``(*B, 4)``, m and m/s."""
        # By itself first, and then against the robot, in the axes that it has after the step.
        p, v = moved_evenly(x, dt).chunk(2, dim=-1)
        if self.wheels is None:
            return torch.cat((p - x_rob, v), dim=-1)
        turned = (self.wheels.axes_after(x_rob) * v.unsqueeze(-2)).sum(-1)
        return torch.cat((self.wheels.seen_after(p, x_rob), turned), dim=-1)

    def _transition(self, x_rob: Tensor, dt: Tensor) -> Tensor:
        """∂moved/∂x = (R, R dt; 0, R), ``(*B, 4, 4)``."""
        if self.wheels is None:
            # R = I in the axes of the world; those of a robot on wheels turn.
            axes = torch.eye(2, dtype=x_rob.dtype, device=x_rob.device)
            axes = axes.expand(*x_rob.shape[:-1], 2, 2)
        else:
            axes = self.wheels.axes_after(x_rob)

        of_position = torch.cat((axes, axes * dt.unsqueeze(-1)), dim=-1)
        of_velocity = torch.cat((torch.zeros_like(axes), axes), dim=-1)
        return torch.cat((of_position, of_velocity), dim=-2)

    def _drift(self, x: Tensor) -> Tensor:
        """Variances that a step adds, ``(*B, 4)``."""
        if self.wheels is None:
            by_robot = torch.zeros_like(x[..., :2]) + self.motion_noise**2
        else:
            by_robot = self.wheels.variances(x[..., :2], self.motion_noise)

        of_position, of_velocity = drift(self.acceleration, self.dt)
        velocity = torch.zeros_like(by_robot) + of_velocity
        return torch.cat((by_robot + of_position, velocity), dim=-1)

    def _measurement(self) -> Measurement:
        """What a reading says of it."""
        jacobian = Interconnection(range_bearing_jacobian, [self.name])
        inputs = [self.name, self.reading]
        residual = Interconnection(range_bearing_residual, inputs, **{self.name: jacobian})
        return Measurement(residual, (self.range_noise**2, self.bearing_noise**2), size=2)


@dataclass(frozen=True)
class GapToCome:
    """The least gap between a robot that stands and an obstacle on its way.

    Attributes:
        radius: Of both together, m.
        horizon: T, how far the way goes, s.
        ahead: ℓ, m: the robot is a capsule from the middle of its axle to the point ahead.
    """

    radius: float
    horizon: float
    ahead: float

    def __post_init__(self) -> None:
        """Check the numbers."""
        check_not_negative(self, ("radius", "horizon", "ahead"))

    def __call__(self, x: Tensor) -> Tensor:
        """The distance from the robot's axis to the way from p to p + v T, less the radius.

        Args:
            x: (p, v), ``(*B, 4)``, m and m/s.

        Returns:
            ``(*B,)``, m; negative where they touch.
        """
        # The way of the obstacle as a segment in space, at the height of the robot's.
        p, height = x[..., :2], torch.zeros_like(x[..., :1])
        end = p + self.horizon * x[..., 2:]
        way = torch.cat((p, height, end, height), dim=-1)

        axle = torch.zeros_like(way[..., :3])
        point_ahead = axle + constants((self.ahead, 0.0, 0.0), axle)
        return segment_distance(torch.cat((axle, point_ahead), dim=-1), way) - self.radius


@dataclass(frozen=True)
class CollisionToCome:
    """exp(−d/ℓ), where d is the gap to come.

    Attributes:
        gap: d.
        length: ℓ, m.
    """

    gap: GapToCome
    length: float

    def __post_init__(self) -> None:
        """Check the length."""
        check_positive(self, ("length",))

    def __call__(self, x: Tensor) -> Tensor:
        """The cost ``(*B,)`` of (p, v), ``(*B, 4)``, m and m/s."""
        return likelihood_across(self.gap(x), self.length)


@dataclass(frozen=True)
class RangeBearingPrior:
    """What is believed of an obstacle at first: it is where it is seen, and rests.

    Attributes:
        range_noise: Standard deviation of the range, m.
        bearing_noise: Standard deviation of the bearing, rad.
        speed: Standard deviation of each component of the velocity, m/s.
    """

    range_noise: float
    bearing_noise: float
    speed: float

    def __call__(self, reading: Tensor) -> tuple[Tensor, Tensor]:
        """Mean ``(*B, 4)`` and covariance ``(*B, 4, 4)`` by range and bearing ``(*B, 2)``."""
        distance, bearing = reading[..., :1], reading[..., 1]
        ahead = torch.cat((distance, torch.zeros_like(distance)), dim=-1)
        place, at_rest = rotate(ahead, bearing), torch.zeros_like(ahead)

        across = (self.bearing_noise * distance) ** 2  # in any direction, to be on the safe side
        of_position = (self.range_noise**2 + across).expand_as(ahead)
        of_velocity = torch.zeros_like(ahead) + self.speed**2
        variances = torch.cat((of_position, of_velocity), dim=-1)
        return torch.cat((place, at_rest), dim=-1), torch.diag_embed(variances)


def range_bearing_residual(x: Tensor, z: Tensor) -> Tensor:
    """(‖p‖, atan2(p_y, p_x)) − z: zero where an obstacle is where it is seen.

    Args:
        x: (p, v), ``(*B, 4)``, m and m/s.
        z: Range and bearing, ``(*B, 2)``, m and rad.

    Returns:
        ``(*B, 2)``, m and rad in [−π, π).
    """
    p = x[..., :2]
    distance = norm(p).unsqueeze(-1) - z[..., :1]
    return torch.cat((distance, bearing_residual(p, z[..., 1:])), dim=-1)


def range_bearing_jacobian(x: Tensor) -> Tensor:
    """∂residual/∂x, ``(*B, 2, 4)``: by the position (p/‖p‖; (−y, x)/‖p‖²), by the velocity 0."""
    p = x[..., :2]
    by_position = torch.cat((unit(p).unsqueeze(-2), bearing_jacobian(p)), dim=-2)
    return torch.cat((by_position, torch.zeros_like(by_position)), dim=-1)
