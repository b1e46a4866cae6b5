"""Estimators of the pusher: where it is and how fast."""

from aicon_torch.estimation import EKF, Estimator, Measurement, ekf_with_delay
from aicon_torch.interconnections import Affine
from aicon_torch.models.pusht.benchmark import PIXEL, PRIOR_DEVIATION, PROCESS_NOISE, PUSHER_NOISE
from aicon_torch.models.pusht.options import Options
from aicon_torch.parts.prior import ReadingPrior, first_belief
from aicon_torch.parts.servo import PusherMotion, Servo

UNFILTERED_VARIANCE = 1e-9 * PIXEL**2
"""Variance of a reading that is taken as it comes, m²: next to nothing."""


def pusher_estimators(options: Options, servo: Servo) -> list[Estimator]:
    """x_pusher, v_pusher: the pusher's position and velocity."""
    return [_position(options), motion_in_step(options, servo)]


def motion_in_step(options: Options, servo: Servo) -> PusherMotion:
    """d_pusher, v_pusher: the pusher's way through its last step."""
    return PusherMotion(servo if options.command == "position" else None)


def _position(options: Options) -> EKF:
    """The position as it is read."""
    variance = PUSHER_NOISE**2 if options.estimation else UNFILTERED_VARIANCE
    agreement = Affine(x_pusher=1.0, z_pusher=-1.0)
    return ekf_with_delay(
        "x_pusher",
        "P_pusher",
        delay=options.filtered_delay,
        sensor="z_pusher",
        moved_by={"a": 2, "dt": 1},
        predict=Affine(x_pusher=1.0, a="dt"),
        noise=PROCESS_NOISE**2,
        initial=first_belief(ReadingPrior((PRIOR_DEVIATION**2,) * 2), "z_pusher"),
        size=2,
        correct=[Measurement(agreement, variance, size=2)],
    )
