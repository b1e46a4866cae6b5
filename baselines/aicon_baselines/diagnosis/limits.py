"""Actuators at their limits or too coarse, and goals that never rest."""

from collections.abc import Iterator

import numpy as np

from aicon_baselines.diagnosis.behaviour import STILL
from aicon_baselines.diagnosis.finding import Finding, listed, percent
from aicon_baselines.diagnosis.history import ActuatorCurve, History
from aicon_baselines.diagnosis.recurrence import upward_crossings

AT_LIMIT = 0.99
"""Share of its limit from which on an actuator is at it."""

MOSTLY = 0.8
"""Share of the time."""

HELD_BACK = 0.5
"""Share of its limit below which an actuator with constraints counts as slowed down."""

SWINGS = 3
"""How often a cost must rise to be called restless."""


def find_limits(history: History, since: int) -> Iterator[Finding]:
    """Actuators that were at their limit most of the time, from a step on."""
    for name, curve in history.actuators.items():
        shares = (curve.share[since:] >= AT_LIMIT).mean(axis=0)
        components = [index for index, share in enumerate(shares) if share >= MOSTLY]
        if not components:
            continue

        which = "" if len(shares) == 1 else f", component {listed([str(i) for i in components])},"
        text = (
            f"{name}{which} is at its limit for {percent(shares[components].min())} of the time: "
            "the goals ask for more than it can do."
        )
        yield Finding("limit", text, since * history.dt, (name,))


def find_slowness(history: History, since: int) -> Iterator[Finding]:
    """Actuators that are kept well below their limit by what else constrains them."""
    for name, curve in history.actuators.items():
        used = float(np.median(curve.share[since:].max(axis=1)))
        if curve.constraints and STILL < used < HELD_BACK:
            text = (
                f"{name} uses {percent(used)} of its limit: it is slowed down by "
                f"{listed(curve.constraints)}, so everything takes longer."
            )
            yield Finding("constraint", text, since * history.dt, (name,))


def find_coarseness(history: History, since: int) -> Iterator[Finding]:
    """Actuators that rest although a gradient is left."""
    for name, curve in history.actuators.items():
        if not _rests_on_a_slope(curve, since):
            continue
        text = (
            f"{name} rests although a gradient is left there ({curve.gradient[-1]:.3g}). Its "
            "action is found in inner steps on the cost that the model foresees, and each of them "
            "undoes the one before: that cost has a sharp valley here, or is nearer to its least "
            f"than the smallest step, {percent(curve.smallest or 0.0)} of the limit, can tell."
        )
        yield Finding("limit", text, since * history.dt, (name,))


def find_restlessness(history: History, since: int) -> Iterator[Finding]:
    """Goals whose cost rises and falls and never settles, from a step on."""
    for name, whole in history.costs.items():
        cost = whole[since:]
        low, span = float(cost.min()), float(np.ptp(cost))
        if span < 0.05 * float(np.ptp(whole)):
            continue

        swings = len(upward_crossings(cost, low + 0.25 * span, low + 0.75 * span))
        if swings >= SWINGS:
            text = (
                f"{name} never rests: its cost rose {swings} times from about {low:.3g} to about "
                f"{low + span:.3g}, and fell again."
            )
            yield Finding("restlessness", text, since * history.dt, (name,))


def _rests_on_a_slope(curve: ActuatorCurve, since: int) -> bool:
    """Whether nothing moves at an actuator where a gradient arrives."""
    settled = (since + len(curve.gradient)) // 2
    if curve.smallest is None or curve.share[settled:].max(initial=0.0) > STILL:
        return False
    strongest = float(curve.gradient.max(initial=0.0))
    return float(curve.gradient[settled:].min(initial=np.inf)) > 1e-3 * strongest > 0
