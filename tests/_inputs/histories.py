"""Recorded episodes made by hand, of which it is known what happened."""

from typing import Any

import numpy as np

from aicon_baselines.diagnosis.history import (
    ActuatorCurve,
    FloatArray,
    History,
    MeetingCurve,
)
from aicon_baselines.diagnosis.innovations import Innovations

DT = 0.1  # s
STEPS = 400


def circling(period: float, noise: float = 0.0) -> FloatArray:
    """A place in the plane that is circled with a period in s, (STEPS, 2), m."""
    angle = 2 * np.pi * DT * np.arange(STEPS) / period
    circle = np.stack((np.cos(angle), np.sin(angle)), axis=1)
    return circle + noise * np.random.default_rng(0).normal(size=circle.shape)


def resting(since: float) -> FloatArray:
    """A place that is approached for a while, in s, and then kept, (STEPS, 2), m."""
    way = np.minimum(DT * np.arange(STEPS) / since, 1.0)
    return np.stack((way, 2 * way), axis=1)


def straight() -> FloatArray:
    """A place that moves on evenly, (STEPS, 2), m."""
    return np.stack((0.1 * DT * np.arange(STEPS), np.zeros(STEPS)), axis=1)


def history(state: FloatArray, **curves: Any) -> History:
    """An episode of this state, and of whatever else is given."""
    return History(DT, state, **curves)


def conflict(cosine: float, exploring: bool, magnitudes: tuple[float, float]) -> MeetingCurve:
    """ "arrive" and "keep off" meet all the time, with the same cosine and magnitudes."""
    return MeetingCurve(
        labels=("arrive → p → x", "keep off → o → x"),
        goals=("arrive", "keep off"),
        magnitudes=np.tile(magnitudes, (STEPS, 1)),
        dominant=np.zeros(STEPS, dtype=np.int64),
        opponent=np.ones(STEPS, dtype=np.int64),
        cosine=np.full(STEPS, cosine),
        exploring=np.full(STEPS, exploring),
    )


def actuator(share: float, gradient: float = 1.0, **others: Any) -> ActuatorCurve:
    """An actuator of two components, of which the second is at some share of its limit."""
    return ActuatorCurve(
        share=np.tile((0.1 * share, share), (STEPS, 1)),
        gradient=np.full(STEPS, gradient),
        escaping=np.zeros(STEPS, dtype=np.bool_),
        **others,
    )


def innovation(mean: float, deviation: float) -> Innovations:
    """Whitened innovations of a reading of one component, drawn from a normal distribution."""
    drawn = np.random.default_rng(0).normal(mean, deviation, size=(STEPS, 1))
    return Innovations("p", ("z",), drawn)
