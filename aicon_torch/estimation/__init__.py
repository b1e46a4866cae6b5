"""Recursive estimators, and the Kalman filtering behind them."""

from aicon_torch.estimation.base import Estimator
from aicon_torch.estimation.correction import Correction
from aicon_torch.estimation.covariance import Covariance, Noise, covariance_name
from aicon_torch.estimation.deterministic import Deterministic
from aicon_torch.estimation.ekf import EKF, Derivative
from aicon_torch.estimation.kalman import KalmanFilter
from aicon_torch.estimation.late import LateEKF, ekf_with_delay
from aicon_torch.estimation.measurement import Innovation, Measurement

__all__ = [
    "EKF",
    "Correction",
    "Covariance",
    "Derivative",
    "Deterministic",
    "Estimator",
    "Innovation",
    "KalmanFilter",
    "LateEKF",
    "Measurement",
    "Noise",
    "covariance_name",
    "ekf_with_delay",
]
