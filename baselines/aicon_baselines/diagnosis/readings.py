"""Readings that do not come, and readings that disagree with the estimates."""

from collections.abc import Iterator

import numpy as np

from aicon_baselines.diagnosis.conflicts import OFTEN
from aicon_baselines.diagnosis.finding import Finding, listed, percent
from aicon_baselines.diagnosis.history import History
from aicon_baselines.diagnosis.innovations import Innovations

LARGE = 9.0
"""A normalised innovation squared from which on a reading contradicts an estimate: 3 deviations."""

MOSTLY = 0.5
"""Share of the time in which they do. A coarse model is contradicted now and then, and may be."""

BIASED = 2.0
"""Mean of a whitened innovation, in standard deviations, from which on it leans to one side."""


def find_silence(history: History, since: int) -> Iterator[Finding]:
    """Sensors without a reading in much of the time, from a step on."""
    for name, present in history.present.items():
        missing = ~present[since:]
        if missing.mean() < OFTEN:
            continue
        text = f"{name} had no reading for {percent(missing.mean())} of the time"
        text += ", and none at the end." if missing[-1] else "."
        yield Finding("silence", text, since * history.dt, (name,))


def find_disagreements(history: History, since: int) -> Iterator[Finding]:
    """Estimates whose readings differ from what was expected by more than their noises allow."""
    for curve in history.innovations:
        squared = curve.squared[since:]
        squared = squared[np.isfinite(squared)]
        if not curve.readings or len(squared) == 0:
            continue

        large = (squared > LARGE).mean()
        lean = np.abs(np.nanmean(curve.whitened[since:], axis=0))
        if large >= MOSTLY or lean.max() > BIASED:
            text = _in_words(curve, squared.mean(), large, lean.max())
            yield Finding("disagreement", text, since * history.dt, (curve.estimate,))


def _in_words(curve: Innovations, mean: float, large: float, lean: float) -> str:
    """How much an estimate and its readings disagree."""
    sides = " and mostly to the same side" if lean > BIASED else ""
    return (
        f"{curve.estimate} disagrees with its readings, {listed(curve.readings)}: they differ from "
        f"what was expected by more than three standard deviations in {percent(large)} of the time"
        f"{sides} (mean squared innovation {mean:.3g}, 1 is expected). Something moves it that the "
        "model does not know, or the noises are set too small."
    )
