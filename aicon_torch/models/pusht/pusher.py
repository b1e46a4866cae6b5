"""Estimators of the pusher: where it is and how fast."""

from typing import Any

import torch
from torch import Tensor

from aicon_torch.estimation import EKF, Estimator, LateEKF, Measurement
from aicon_torch.interconnections import Affine
from aicon_torch.models.pusht.benchmark import PIXEL, PRIOR_DEVIATION
from aicon_torch.models.pusht.options import Options
from aicon_torch.parts.servo import PusherMotion, Servo

UNFILTERED_VARIANCE = 1e-9 * PIXEL**2
"""Variance of a reading that is taken as it comes, m²: next to nothing."""


def pusher_estimators(options: Options, servo: Servo) -> list[Estimator]:
    """x_pusher, v_pusher: the pusher's position and velocity."""
    return [_position(options), motion_in_step(options, servo)]


def motion_in_step(options: Options, servo: Servo) -> PusherMotion:
    """d_pusher, v_pusher: the pusher's way through its last step."""
    return PusherMotion(servo if options.command == "position" else None)


def first_position(z_pusher: Tensor) -> tuple[Tensor, Tensor]:
    """The prior at the first reading: mean ``(*B, 2)``, m, and covariance ``(2, 2)``, m²."""
    identity = torch.eye(2, dtype=z_pusher.dtype, device=z_pusher.device)
    return z_pusher, PRIOR_DEVIATION**2 * identity


def _position(options: Options) -> EKF:
    """The position as it is read."""
    variance = options.pusher_noise**2 if options.estimation else UNFILTERED_VARIANCE
    agreement = Affine(x_pusher=1.0, z_pusher=-1.0)
    belief: dict[str, Any] = {
        "predict": Affine(x_pusher=1.0, a="dt"),
        "noise": options.process_noise**2,
        "initial": first_position,
        "size": 2,
        "correct": [Measurement(agreement, variance, size=2)],
    }

    if not options.is_delayed:
        return EKF("x_pusher", "P_pusher", **belief)
    late: dict[str, Any] = {
        "sensor": "z_pusher",
        "steps": options.delay,
        "moved_by": {"a": 2, "dt": 1},
    }
    return LateEKF("x_pusher", "P_pusher", **late, **belief)
