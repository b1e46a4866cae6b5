"""Estimators of the pusher: where it is and how fast."""

from collections.abc import Callable

import torch
from torch import Tensor

from aicon_torch.estimation import EKF, Deterministic, Estimator, Measurement
from aicon_torch.interconnections import Affine
from aicon_torch.models.pusht.benchmark import PIXEL, PRIOR_DEVIATION
from aicon_torch.models.pusht.options import Options
from aicon_torch.parts.delay import MotionHistory, current_position, delayed_position
from aicon_torch.parts.servo import PusherMotion, Servo

UNFILTERED_VARIANCE = 1e-9 * PIXEL**2
"""Variance of a reading that is taken as it comes, m²: next to nothing."""


def pusher_estimators(options: Options, servo: Servo) -> list[Estimator]:
    """x_pusher, v_pusher: the pusher's position and velocity."""
    motion_in_step = PusherMotion(servo if options.command == "position" else None)
    if not options.is_delayed:
        motion = Affine(x_pusher=1.0, a=options.dt)
        return [_position(options, "x_pusher", "P_pusher", motion), motion_in_step]

    # With a delay the position of then is filtered, and moved on to now.
    return [
        motion_in_step,
        MotionHistory(options.delay + 1, motion_in_step.parts),
        _position(options, "y_pusher", "Q_pusher", delayed_position),
        Deterministic("x_pusher", current_position),
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
