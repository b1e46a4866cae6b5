"""The Kalman filter: an EKF whose relations are affine, so nothing has to be linearised."""

from collections.abc import Sequence

from aicon_torch.errors import GraphError
from aicon_torch.estimation.covariance import Noise
from aicon_torch.estimation.ekf import EKF
from aicon_torch.estimation.measurement import Measurement, in_turn
from aicon_torch.interconnections import Affine


class KalmanFilter(EKF):
    """A Kalman filter: an :class:`EKF` whose prediction and measurements are :class:`Affine`.

    Args:
        mean: Name of x.
        covariance: Name of P.
        predict: ``Affine(x=A, u=B)``.
        noise: Variances of Q, per step.
        initial: Mean and variances before the first step.
        correct: Measurements whose residual is Affine, such as ``Affine(x=1.0, z=-1.0)``.
        is_motion: Whether the mean is itself a motion, such as a velocity that odometry measures.

    Example:
        >>> KalmanFilter(
        ...     "x", "P", predict=Affine(x=1.0, a=0.05), noise=1e-6, initial=((0.0, 0.0), 1.0),
        ...     correct=[Measurement(Affine(x=1.0, z=-1.0), noise=0.01, size=2)],
        ... )
    """

    def __init__(
        self,
        mean: str,
        covariance: str,
        *,
        predict: Affine,
        noise: Noise,
        initial: tuple[Sequence[float], float | Sequence[float]],
        correct: Sequence[Measurement] = (),
        is_motion: bool = False,
    ) -> None:
        # Affine relations are their own linearisation, so that what an EKF does is exact.
        correct = in_turn(f"correct of {mean!r}", correct)
        relations = [predict, *(measurement.residual for measurement in correct)]
        if not all(isinstance(relation, Affine) for relation in relations):
            raise GraphError(
                f"KalmanFilter {mean!r}: prediction and measurements must be Affine; an EKF takes "
                "any function."
            )
        super().__init__(
            mean,
            covariance,
            predict=predict,
            noise=noise,
            initial=initial,
            correct=correct,
            is_motion=is_motion,
        )
