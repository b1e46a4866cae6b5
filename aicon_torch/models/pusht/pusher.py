"""Estimators of the pusher: where it is and how fast."""

from collections.abc import Callable

import torch
from torch import Tensor

from aicon_torch.estimation import EKF, Deterministic, Estimator, KalmanFilter, Measurement
from aicon_torch.interconnections import Affine
from aicon_torch.models.pusht.benchmark import PIXEL, PRIOR_DEVIATION
from aicon_torch.models.pusht.options import Options
from aicon_torch.parts.delay import ActionHistory, current_position, delayed_position
from aicon_torch.parts.servo import Servo

UNFILTERED_VARIANCE = 1e-9 * PIXEL**2
"""Variance of a reading that is taken as it comes, m²: next to nothing."""

VELOCITY_VARIANCE = PIXEL**2
"""Variance of the pusher's velocity, m²/s²; nothing corrects it."""


def pusher_estimators(options: Options, servo: Servo) -> list[Estimator]:
    """x_pusher, v_pusher: the pusher's position and velocity."""
    velocity = _velocity(options, servo)
    if not options.is_delayed:
        motion = Affine(x_pusher=1.0, a=options.dt)
        return [_position(options, "x_pusher", "P_pusher", motion), velocity]

    # With a delay the position of then is filtered, and moved on to now.
    return [
        ActionHistory(options.delay + 1),
        _position(options, "y_pusher", "Q_pusher", delayed_position),
        Deterministic("x_pusher", current_position),
        velocity,
    ]


def first_position(z_pusher: Tensor) -> tuple[Tensor, Tensor]:
    """The prior at the first reading: mean ``(*B, 2)``, m, and covariance ``(2, 2)``, m²."""
    identity = torch.eye(2, dtype=z_pusher.dtype, device=z_pusher.device)
    return z_pusher, PRIOR_DEVIATION**2 * identity


def _position(
    options: Options, name: str, covariance: str, motion: Callable[..., Tensor] | Affine
) -> EKF:
    """The position as it is read."""
    variance = options.pusher_noise**2 if options.estimation else UNFILTERED_VARIANCE
    agreement = Affine(**{name: 1.0, "z_pusher": -1.0})

    return EKF(
        name,
        covariance,
        predict=motion,
        noise=options.process_noise**2,
        initial=first_position,
        size=2,
        correct=[Measurement(agreement, variance, size=2)],
    )


def _velocity(options: Options, servo: Servo) -> KalmanFilter:
    """The velocity as the PD controller leaves it; one that is commanded is there at once."""
    change = Affine(v_pusher=0.0, a=1.0)
    if options.command == "position":
        by_motion = servo.velocity_by_offset / servo.displacement_by_offset[-1]
        kept = servo.velocity_by_velocity - by_motion * servo.displacement_by_velocity[-1]
        change = Affine(v_pusher=kept, a=by_motion * options.dt)

    return KalmanFilter(
        "v_pusher",
        "P_velocity",
        predict=change,
        noise=VELOCITY_VARIANCE,
        initial=((0.0, 0.0), VELOCITY_VARIANCE),
    )
