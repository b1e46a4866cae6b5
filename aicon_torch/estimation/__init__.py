"""Recursive estimators."""

from aicon_torch.estimation.ekf import EKF, Deterministic, Estimator, KalmanFilter
from aicon_torch.estimation.measurement import Correction, Covariance, Derivative, Measurement, Noise

__all__ = ["EKF", "Correction", "Covariance", "Derivative", "Deterministic", "Estimator", "KalmanFilter", "Measurement", "Noise"]
