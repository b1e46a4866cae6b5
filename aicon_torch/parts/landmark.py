"""A landmark that a robot sees: p_tar, its position relative to the robot.

The axes are those of the world, and only the origin moves with the robot; those of a robot on
wheels are its own, and turn with it.
"""

from dataclasses import dataclass
from functools import partial
from typing import Literal, get_args

import torch
from torch import Tensor

from aicon_torch.estimation import EKF, Measurement, covariance_name, ekf_with_delay
from aicon_torch.interconnections import Affine, Interconnection
from aicon_torch.parts.planar import quarter_turn
from aicon_torch.parts.prior import ReadingPrior, first_belief
from aicon_torch.parts.wheels import Wheels
from aicon_torch.validation import (
    check_choice,
    check_count,
    check_not_negative,
    check_positive,
)
from aicon_torch.vectors import constants, wrap_angle

Sight = Literal["bearing", "position"]
"""What a robot sees of a landmark."""

NEAREST = 1e-4
"""Squared distance below which a bearing's derivative grows no more, m²: 1 cm."""


def approach(name: str = "p_tar", motion: str = "x_rob") -> Affine:
    """p_tar − x_rob: the landmark comes nearer by what the robot moves, ``(*B, 2)``, m."""
    return Affine(**{name: 1.0, motion: -1.0})


def bearing_residual(p_tar: Tensor, z_tar: Tensor) -> Tensor:
    """atan2(y, x) − z: zero where a landmark lies in the direction in which it is seen.

    Args:
        p_tar: Its position (x, y), ``(*B, 2)``, m.
        z_tar: The bearing, ``(*B, 1)``, rad.

    Returns:
        ``(*B, 1)``, rad in [−π, π).
    """
    return wrap_angle(torch.atan2(p_tar[..., 1:], p_tar[..., :1]) - z_tar)


def bearing_jacobian(p_tar: Tensor) -> Tensor:
    """∂bearing/∂p = (−y, x)/‖p‖², ``(*B, 1, 2)``, rad/m; nearer than 1 cm as at 1 cm."""
    squared_distance = (p_tar * p_tar).sum(-1, keepdim=True).clamp(min=NEAREST)
    return (quarter_turn(p_tar) / squared_distance).unsqueeze(-2)


@dataclass(frozen=True)
class BearingPrior:
    """Where a landmark is believed at first: at some distance along the first bearing.

    Attributes:
        distance: Believed distance, m.
        across: Standard deviation across the line of sight, m.
        along: Standard deviation along the line of sight, m.

    Raises:
        OptionError: If a number is negative.
    """

    distance: float
    across: float
    along: float

    def __post_init__(self) -> None:
        """Check the numbers."""
        check_not_negative(self, ("distance", "across", "along"))

    def __call__(self, z_tar: Tensor) -> tuple[Tensor, Tensor]:
        """Mean ``(*B, 2)``, m, and covariance ``(*B, 2, 2)``, m², by a bearing ``(*B, 1)``, rad."""
        sight = torch.cat((torch.cos(z_tar), torch.sin(z_tar)), dim=-1)
        identity = torch.eye(2, dtype=z_tar.dtype, device=z_tar.device)

        # Uncertain across the line of sight s, and along it more: σ_a² I + (σ_l² − σ_a²) s sᵀ.
        variance_gap = self.along**2 - self.across**2
        elongation = variance_gap * sight.unsqueeze(-1) * sight.unsqueeze(-2)
        return self.distance * sight, elongation + self.across**2 * identity


def expected_distance(p_tar: Tensor, P_tar: Tensor) -> Tensor:
    """g₁ = ‖μ_tar‖ + tr Σ_tar: how far a landmark is, and how uncertain.

    Args:
        p_tar: μ, ``(*B, 2)``, m.
        P_tar: Σ, ``(*B, 2, 2)``, m².

    Returns:
        ``(*B,)``; the text adds the two as they are, 1 m² counting as 1 m.
    """
    distance = torch.linalg.vector_norm(p_tar, dim=-1)
    uncertainty = P_tar.diagonal(dim1=-2, dim2=-1).sum(-1)
    cost: Tensor = distance + uncertainty
    return cost


@dataclass(frozen=True)
class Landmark:
    """A landmark that stays where it is, as an estimator and a goal of any graph.

    The belief N(p, P) of its position relative to the robot moves against the robot,

        p⁻ = p − x_rob,   P⁻ = P + σ_x² I,

    and is corrected by its bearing, atan2(p_y, p_x) − z = 0, or by its position, p − z = 0. In the
    axes of a robot on wheels it turns as well, p⁻ = R(−θ) (p − chord), and an error of the motion
    moves it the farther, the farther it is; what is to come near is then the point ahead.

    Attributes:
        name: Of the estimate p, ``(*B, 2)``, m, such as ``"p_tar"``; its covariance is ``"P_tar"``.
        reading: The sensor: a bearing ``(*B, 1)``, rad, or a position ``(*B, 2)``, m.
        noise: Standard deviation of a reading, rad or m.
        motion_noise: σ_x, standard deviation of what the robot moves in a step besides ``motion``,
            m.
        sees: ``"bearing"`` or ``"position"``.
        prior: Where it is believed by the first bearing.
        motion: The quantity that says how far the robot has moved in a step, ``(*B, 2)``, m.
        delay: Largest age of a reading that is made up for, steps.
        wheels: Of a robot on wheels, whose axes then are those of p and of the readings.

    Raises:
        OptionError: If a number or a choice is not what it may be.

    Example:
        >>> tree = Landmark("p_tree", "z_tree", noise=0.03, motion_noise=0.001)
        >>> estimators = [Deterministic("x_rob", displacement, is_motion=True), tree.estimator()]
        >>> goals = [Goal("reach", tree.expected_distance())]
    """

    name: str
    reading: str
    noise: float
    motion_noise: float
    sees: Sight = "bearing"
    prior: BearingPrior = BearingPrior(distance=5.0, across=0.15, along=3.0)
    motion: str = "x_rob"
    delay: int = 0
    wheels: Wheels | None = None

    def __post_init__(self) -> None:
        """Check the numbers."""
        check_positive(self, ("noise",))
        check_not_negative(self, ("motion_noise",))
        check_choice(self, "sees", get_args(Sight))
        check_count(self, ("delay",), "number of steps")

    @property
    def covariance(self) -> str:
        """Name of P, ``(*B, 2, 2)``, m²."""
        return covariance_name(self.name)

    def estimator(self) -> EKF:
        """The filter of its position."""
        return ekf_with_delay(
            self.name,
            self.covariance,
            delay=self.delay,
            sensor=self.reading,
            moved_by={self.motion: 2, "dt": 1},
            predict=self._approach(),
            noise=self._spread(),
            initial=self._first_belief(),
            size=2,
            correct=[self._measurement()],
        )

    def expected_distance(self) -> Interconnection:
        """The cost ‖p‖ + tr P, ``(*B,)``, of a robot on wheels from the point ahead.

        See :func:`expected_distance`.
        """
        cost = expected_distance if self.wheels is None else self._distance_ahead
        return Interconnection(cost, [self.name, self.covariance])

    def _distance_ahead(self, p_tar: Tensor, P_tar: Tensor) -> Tensor:
        """How far a landmark is from the point ahead, and how uncertain, ``(*B,)``."""
        assert self.wheels is not None
        return expected_distance(p_tar - constants((self.wheels.ahead, 0.0), p_tar), P_tar)

    def _approach(self) -> Interconnection:
        """How it comes nearer as the robot moves."""
        if self.wheels is None:
            return approach(self.name, self.motion)

        # By the landmark, the derivative is the turn of the axes and nothing else.
        turned = Interconnection(self.wheels.axes_after, [self.motion])
        inputs = [self.name, self.motion]
        return Interconnection(self.wheels.seen_after, inputs, **{self.name: turned})

    def _spread(self) -> float | Interconnection:
        """Variances of what the robot moves besides."""
        if self.wheels is None:
            return self.motion_noise**2
        spread = partial(self.wheels.variances, deviation=self.motion_noise)
        return Interconnection(spread, [self.name])

    def _first_belief(self) -> Interconnection:
        """Where it is believed by the first reading."""
        if self.sees == "bearing":
            return first_belief(self.prior, self.reading)
        return first_belief(ReadingPrior((self.noise**2,) * 2), self.reading)

    def _measurement(self) -> Measurement:
        """What a reading says of it."""
        if self.sees == "position":
            agreement = Affine(**{self.name: 1.0, self.reading: -1.0})
            return Measurement(agreement, self.noise**2, size=2)

        jacobian = Interconnection(bearing_jacobian, [self.name])
        inputs = [self.name, self.reading]
        residual = Interconnection(bearing_residual, inputs, **{self.name: jacobian})
        return Measurement(residual, self.noise**2)
