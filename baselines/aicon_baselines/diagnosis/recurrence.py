"""Recurrence: whether a curve in several dimensions comes back, and after which time."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

ALIKE = 0.75
"""Similarity from which on a curve counts as repeating itself."""

ROUNDS = 3
"""How often it must do so to be called a cycle."""


class Returns(NamedTuple):
    """When a curve came back to where it was: the steps, (k,), and their median distance."""

    steps: IntArray
    period: float


def normalised(state: FloatArray) -> FloatArray:
    """The components by their standard deviation in the whole episode, (n, d); none moves less."""
    deviation = state.std(axis=0)
    moves = deviation > 1e-9 * np.abs(state).max(initial=1e-9, axis=0)
    scaled: FloatArray = np.where(moves, state / np.where(moves, deviation, 1.0), 0.0)
    return scaled


def similarity(curve: FloatArray) -> FloatArray:
    """How alike a curve is to itself after some steps: s(k) = 1 − ⟨|x(t+k) − x(t)|²⟩ / 2σ².

    1 stands for a repetition, 0 for no relation, and −1 for the opposite; σ² is the variance of all
    components together. For a stationary curve it is its autocorrelation.

    Args:
        curve: (n, d), n ≥ 3.

    Returns:
        s(0) … s(m), with m = n // ROUNDS.
    """
    centred = curve - curve.mean(axis=0)
    variance = float((centred**2).sum(axis=1).mean())
    if variance == 0:
        return np.ones(len(curve) // ROUNDS + 1)

    alike = [1.0]
    for lag in range(1, len(curve) // ROUNDS + 1):
        squared = ((centred[lag:] - centred[:-lag]) ** 2).sum(axis=1)
        alike.append(1.0 - float(squared.mean()) / (2.0 * variance))
    return np.array(alike)


def find_period(curve: FloatArray) -> int | None:
    """After how many steps a curve repeats itself, three times or more; None if it does not.

    Args:
        curve: (n, d).
    """
    if len(curve) < 2 * ROUNDS:
        return None
    alike = similarity(curve)

    # The first lobe after it has been unlike itself.
    unlike = np.flatnonzero(alike < 0.5 * ALIKE)
    if len(unlike) == 0:
        return None
    again = np.flatnonzero(alike[unlike[0] :] >= ALIKE) + unlike[0]
    if len(again) == 0:
        return None
    lobe = np.split(again, np.flatnonzero(np.diff(again) > 1) + 1)[0]
    return round(summit(lobe, alike[lobe]))


def summit(lags: IntArray, alike: FloatArray) -> float:
    """Where the parabola through a lobe, (k,), is highest: with noise the largest value is not."""
    if len(lags) < 3:
        return float(lags[alike.argmax()])
    curvature, slope, _ = np.polyfit(lags - lags.mean(), alike, 2)
    if curvature >= 0.0:
        return float(lags[alike.argmax()])
    return float(np.clip(lags.mean() - 0.5 * slope / curvature, lags[0], lags[-1]))


def repeats_since(curve: FloatArray, period: int) -> int:
    """The step from which on a curve repeats itself after a period, to its end."""
    squared = ((curve[period:] - curve[:-period]) ** 2).sum(axis=1)
    tail = curve[-3 * period :]
    variance = float(((tail - tail.mean(axis=0)) ** 2).sum(axis=1).mean())

    # Averaged over a period, so that a moment in which it differs does not count.
    average = np.convolve(squared, np.full(period, 1.0 / period), mode="valid")
    differs = np.flatnonzero(average > 2.0 * variance * (1.0 - 0.5 * ALIKE))
    return 0 if len(differs) == 0 else int(differs[-1]) + 1


def find_returns(curve: FloatArray) -> Returns | None:
    """When a curve came back to where it was, at intervals that may differ; None if it did not.

    Along its first principal component a return is a change from below −σ/2 to above +σ/2.

    Args:
        curve: (n, d).
    """
    centred = curve - curve.mean(axis=0)
    _, _, directions = np.linalg.svd(centred, full_matrices=False)
    along = centred @ directions[0]
    steps = upward_crossings(along, -0.5 * along.std(), 0.5 * along.std())
    if len(steps) <= ROUNDS:
        return None

    # It must be the same place each time.
    spread = float(centred[steps].var(axis=0).sum())
    if spread > 0.3 * float(centred.var(axis=0).sum()):
        return None
    return Returns(steps, float(np.median(np.diff(steps))))


def upward_crossings(values: FloatArray, low: float, high: float) -> IntArray:
    """Where values (n,) come above `high` after they were below `low`."""
    crossings: list[int] = []
    was_low = False
    for step, value in enumerate(values.tolist()):
        if value < low:
            was_low = True
        elif value > high and was_low:
            crossings.append(step)
            was_low = False
    return np.array(crossings, dtype=np.int64)
