"""A clearance with its direction, x_obs = (d, ∇d): how far an obstacle is, and how that grows.

The sensor feels d alone. ∇d is estimated from how d changes with the robot's motion.
"""

from dataclasses import dataclass

import torch
from torch import Tensor

from aicon_torch.estimation import EKF, Measurement, covariance_name, ekf_with_delay
from aicon_torch.interconnections import Affine, Interconnection
from aicon_torch.parts.prior import ReadingPrior, first_belief
from aicon_torch.validation import check_count, check_not_negative, check_positive
from aicon_torch.vectors import shorten, unit

UNIT_GRADIENT_VARIANCE = 0.05
"""Variance of |∇d| − 1: near a corner a clearance grows by less than one metre a metre."""

TURN_RATE = 2.0
"""Variance by which each component of ∇d grows in a second, m²/m² s⁻¹: obstacles are no walls."""

DIRECTION_VARIANCE = 0.5
"""Variance of each component of ∇d before the first motion: any direction is possible."""


def slide(x_obs: Tensor, x_rob: Tensor) -> Tensor:
    """(d + ∇d·x_rob, ∇d): the clearance after a displacement, as along a straight wall.

    Args:
        x_obs: (d, ∇d), ``(*B, 3)``, m and m/m.
        x_rob: The displacement, ``(*B, 2)``, m.

    Returns:
        ``(*B, 3)``, m and m/m.
    """
    distance, gradient = x_obs[..., :1], x_obs[..., 1:]
    change = (gradient * x_rob).sum(-1, keepdim=True)
    return torch.cat((distance + change, gradient), dim=-1)


def slide_jacobian(x_rob: Tensor) -> Tensor:
    """∂slide/∂x_obs = (1, x_rob; 0, I), ``(*B, 3, 3)``, of a displacement ``(*B, 2)``, m."""
    # x_rob goes into the first row, to the right of the 1 by d.
    by_gradient = torch.nn.functional.pad(x_rob.unsqueeze(-2), (1, 0, 0, 2))
    return torch.eye(3, dtype=x_rob.dtype, device=x_rob.device) + by_gradient


def range_residual(name: str = "x_obs", reading: str = "z_obs") -> Affine:
    """The residual d − z_obs, ``(*B, 1)``, m: zero where the clearance is what the sensor reads."""
    factors: dict[str, float | Tensor] = {name: torch.tensor([[1.0, 0.0, 0.0]]), reading: -1.0}
    return Affine(**factors)


def unit_gradient_residual(x_obs: Tensor) -> Tensor:
    """|∇d| − 1, ``(*B, 1)``, of (d, ∇d) ``(*B, 3)``: a clearance grows by one metre a metre."""
    gradient = x_obs[..., 1:]
    norm: Tensor = torch.linalg.vector_norm(gradient, dim=-1, keepdim=True)
    return norm - 1.0


def unit_gradient_jacobian(x_obs: Tensor) -> Tensor:
    """∂(|∇d| − 1)/∂x_obs = (0, ∇d/|∇d|), ``(*B, 1, 3)``; zero where ∇d is."""
    gradient = x_obs[..., 1:]
    length = torch.linalg.vector_norm(gradient, dim=-1, keepdim=True)
    return torch.nn.functional.pad(gradient / length.clamp(min=1e-9), (1, 0)).unsqueeze(-2)


def direction_residual(x_obs: Tensor, z_dir: Tensor) -> Tensor:
    """∇d + (cos z, sin z): zero where ∇d points away from the nearest obstacle.

    Args:
        x_obs: (d, ∇d), ``(*B, 3)``.
        z_dir: Direction of the nearest obstacle, ``(*B, 1)``, rad.

    Returns:
        ``(*B, 2)``.
    """
    towards = torch.cat((torch.cos(z_dir), torch.sin(z_dir)), dim=-1)
    return x_obs[..., 1:] + towards


@dataclass(frozen=True)
class CollisionLikelihood:
    """g₂ = p_collision = exp(−d/ℓ): its gradient keeps growing toward contact.

    Attributes:
        length: ℓ, m.

    Raises:
        OptionError: If the length is not positive.
    """

    length: float

    def __post_init__(self) -> None:
        """Check the length."""
        check_positive(self, ("length",))

    def __call__(self, x_obs: Tensor) -> Tensor:
        """The likelihood ``(*B,)`` with a clearance (d, ∇d) ``(*B, 3)``."""
        return torch.exp(-x_obs[..., 0] / self.length)


def certain_clearance(x_obs: Tensor, P_obs: Tensor) -> Tensor:
    """The clearance that is certain enough, d − 2σ_d, ``(*B,)``, m.

    Args:
        x_obs: (d, ∇d), ``(*B, 3)``, m and m/m.
        P_obs: Its covariance, ``(*B, 3, 3)``.
    """
    deviation = P_obs[..., 0, 0].clamp(min=0.0).sqrt()
    return x_obs[..., 0] - 2.0 * deviation


@dataclass(frozen=True)
class ClearanceLimits:
    """Near an obstacle a velocity is limited by what may have happened since it was felt.

    With the clearance d₋ = d − 2σ_d − b that is certain enough and the age t of its reading,

        ‖a‖ ≤ max(v_min, d₋/(τ + t)),   n·a ≥ (m − d₋)/(τ + t),

    the latter a damper of the velocity away from the obstacle, which asks for retreat below m.

    Attributes:
        time: τ, s.
        margin: m, m.
        slowest: v_min, m/s: without motion the direction of an obstacle stays unknown.
        offset: b, by how much all readings may be too long, m.

    Raises:
        OptionError: If a number is not what it may be.
    """

    time: float
    margin: float
    slowest: float
    offset: float = 0.0

    def __post_init__(self) -> None:
        """Check the numbers."""
        check_positive(self, ("time", "slowest"))
        check_not_negative(self, ("margin", "offset"))

    @classmethod
    def for_latency(cls, latency: float, offset: float = 0.0) -> "ClearanceLimits":
        """Limits for actions that are so late, s; margin and times are from trials."""
        return cls(time=0.2 + latency, margin=0.04, slowest=0.05, offset=offset)

    def __call__(
        self, a: Tensor, x_obs: Tensor, P_obs: Tensor, age: Tensor | float = 0.0
    ) -> Tensor:
        """The velocity within the limits.

        Args:
            a: The nominal velocity, ``(*B, 2)``, m/s.
            x_obs: (d, ∇d), ``(*B, 3)``, m and m/m.
            P_obs: Its covariance, ``(*B, 3, 3)``.
            age: t, ``(*B, 1)``, s.

        Returns:
            ``(*B, 2)``, m/s.
        """
        certain = certain_clearance(x_obs, P_obs).unsqueeze(-1) - self.offset
        time = self.time + age

        # No faster than what is left allows.
        slowed = shorten(a, (certain / time).clamp(min=self.slowest))

        # Away from the obstacle where it is too near.
        away = unit(x_obs[..., 1:])
        retreat = (self.margin - certain) / time
        missing = (retreat - (slowed * away).sum(-1, keepdim=True)).clamp(min=0.0)
        return slowed + missing * away


@dataclass(frozen=True)
class Clearance:
    """How far the nearest obstacle is, and in which direction: for any graph.

    The belief N(x, P) of x = (d, ∇d) moves with the robot as along a straight wall,

        d⁻ = d + ∇d·x_rob,   ∇d⁻ = ∇d,

    and is corrected by the range, d − z = 0, by |∇d| = 1, and by the direction of the obstacle,
    ∇d + (cos z, sin z) = 0, where that is read.

    Attributes:
        name: Of the estimate, ``(*B, 3)``, m and m/m, such as ``"x_obs"``; its covariance is
            ``"P_obs"``.
        range: The sensor of the clearance, ``(*B, 1)``, m.
        noise: Standard deviation of its readings, m.
        motion_noise: Standard deviation of what the robot moves in a step besides ``motion``, m.
        dt: Time step, s.
        direction: The sensor of the direction of the nearest obstacle, ``(*B, 1)``, rad; None where
            there is none.
        direction_noise: Standard deviation of its readings, rad.
        motion: The quantity that says how far the robot has moved in a step, ``(*B, 2)``, m.
        delay: Largest age of a reading that is made up for, steps.

    Raises:
        OptionError: If a number is not what it may be.

    Example:
        >>> walls = Clearance("x_wall", "z_wall", noise=0.01, motion_noise=0.001, dt=0.05)
        >>> estimators = [Deterministic("x_rob", displacement, is_motion=True), walls.estimator()]
        >>> goals = [Goal("avoid", walls.collision_likelihood(length=0.04))]
    """

    name: str
    range: str
    noise: float
    motion_noise: float
    dt: float
    direction: str | None = None
    direction_noise: float = 0.03
    motion: str = "x_rob"
    delay: int = 0

    def __post_init__(self) -> None:
        """Check the numbers."""
        check_positive(self, ("noise", "dt", "direction_noise"))
        check_not_negative(self, ("motion_noise",))
        check_count(self, ("delay",), "number of steps")

    @property
    def covariance(self) -> str:
        """Name of P, ``(*B, 3, 3)``."""
        return covariance_name(self.name)

    def estimator(self) -> EKF:
        """The filter of the clearance and its direction."""
        # The prediction is linear in x_obs, with a matrix that the motion alone decides.
        slid = Interconnection(slide_jacobian, [self.motion])
        prior = ReadingPrior((self.noise**2, DIRECTION_VARIANCE, DIRECTION_VARIANCE))
        turn_variance = TURN_RATE * self.dt

        return ekf_with_delay(
            self.name,
            self.covariance,
            delay=self.delay,
            sensor=self.range,
            moved_by={self.motion: 2, "dt": 1},
            predict=Interconnection(slide, [self.name, self.motion], **{self.name: slid}),
            noise=(self.motion_noise**2, turn_variance, turn_variance),
            initial=first_belief(prior, self.range),
            size=3,
            correct=self._measurements(),
        )

    def collision_likelihood(self, length: float) -> Interconnection:
        """The cost exp(−d/ℓ), ``(*B,)``, of a length ℓ, m: see :class:`CollisionLikelihood`."""
        return Interconnection(CollisionLikelihood(length), [self.name])

    def limits(self, limits: ClearanceLimits) -> Interconnection:
        """Limits of a velocity ``"a"`` near an obstacle, as a constraint of an actuator."""
        belief = ["a", self.name, self.covariance]
        if not self.delay:
            return Interconnection(limits, belief)

        # A reading that came late is older by the steps in which it was on its way.
        def limited(a: Tensor, x_obs: Tensor, P_obs: Tensor, lag: Tensor, dt: Tensor) -> Tensor:
            return limits(a, x_obs, P_obs, age=lag * dt)

        return Interconnection(limited, [*belief, f"{self.name}_lag", "dt"])

    def _measurements(self) -> list[Measurement]:
        """What the readings say, and that a clearance grows by one metre a metre."""
        # That |∇d| is 1 is a measurement that needs no sensor, and is made at every step.
        grown = Interconnection(unit_gradient_jacobian, [self.name])
        unit_gradient = Interconnection(unit_gradient_residual, [self.name], **{self.name: grown})
        measurements = [
            Measurement(range_residual(self.name, self.range), self.noise**2),
            Measurement(unit_gradient, UNIT_GRADIENT_VARIANCE),
        ]
        if self.direction is None:
            return measurements

        seen = Interconnection(direction_residual, [self.name, self.direction])
        return [*measurements, Measurement(seen, self.direction_noise**2, size=2)]
