"""What the robot did in the end: it stood still, went in circles, was on its way, or wandered."""

import numpy as np

from aicon_baselines.diagnosis.finding import Finding, percent, seconds
from aicon_baselines.diagnosis.history import History
from aicon_baselines.diagnosis.recurrence import (
    find_period,
    find_returns,
    normalised,
    repeats_since,
)
from aicon_baselines.evaluation.recording import BoolArray, FloatArray

STILL = 0.02
"""Share of its range in the episode, or of an actuator's limit, within which nothing moves."""

LASTING = 0.1
"""Share of the episode for which it must last to be the end of it."""


def find_behaviour(history: History) -> Finding:
    """What the robot did in the end."""
    found = (
        find_standstill(history)
        or find_cycle(history)
        or find_returning(history)
        or find_progress(history)
    )
    return found or Finding(
        "wandering",
        "It moved on without rest: it did not stand still, did not repeat itself and came no nearer"
        f". {costs_in_words(history)}",
        begin=history.times[history.steps // 2],
    )


def find_standstill(history: History) -> Finding | None:
    """Whether nothing moved any more from some time on."""
    state = history.state
    span = np.ptp(state, axis=0)
    away = np.abs(state - state[-1]) > STILL * span
    moves = away.any(axis=1)

    # An estimate that is noisy need not be still where the actuators are.
    limited = [curve.share for curve in history.actuators.values()]
    if limited and any(share.any() for share in limited):
        acts = np.concatenate(limited, axis=1).max(axis=1) > STILL
        moves &= acts

    since = _last_true(moves) + 1
    if history.steps - since < max(3, LASTING * history.steps):
        return None
    time = float(history.times[since])
    text = f"It has stood still since {seconds(time)}. {costs_in_words(history)}"
    return Finding("standstill", text, time)


def find_cycle(history: History) -> Finding | None:
    """Whether the same motion came again and again, with one period."""
    curve = normalised(history.state)
    for part in (2, 4, 8):
        period = find_period(curve[-(history.steps // part) :])
        if period is None:
            continue

        since = repeats_since(curve, period)
        time, length = float(history.times[since]), period * history.dt
        rounds = (history.steps - since) / period
        text = (
            f"It has gone in a cycle since {seconds(time)}, of {seconds(length)} each: "
            f"{rounds:.0f} rounds until the end. {costs_in_words(history)}"
        )
        return Finding("cycle", text, time, period=length)
    return None


def find_returning(history: History) -> Finding | None:
    """Whether it came back to the same place several times, at intervals that differ."""
    half = history.steps // 2
    returns = find_returns(normalised(history.state)[half:]) if half > 3 else None
    if returns is None:
        return None

    intervals = np.diff(returns.steps) * history.dt
    shortest, longest = np.quantile(intervals, (0.1, 0.9))
    text = (
        f"It goes to and fro: in the last {seconds((history.steps - half) * history.dt)} it came "
        f"back to where it was {len(returns.steps)} times, mostly after {shortest:.1f} to "
        f"{seconds(longest)}, within {percent(_extent(history, half))} of the space that it used "
        f"in the episode. {costs_in_words(history)}"
    )
    return Finding("cycle", text, float(history.times[half]), period=returns.period * history.dt)


def find_progress(history: History) -> Finding | None:
    """Whether a goal's cost still came to new lows in the last third of the episode."""
    for name, cost in history.costs.items():
        last = _last_low(cost)
        if last < 2 * history.steps // 3:
            continue

        ago = (history.steps - 1 - last) * history.dt
        when = "at its very end" if ago == 0 else f"{seconds(ago)} before its end"
        text = (
            f"It was on its way when the episode ended: {name} had its least cost, "
            f"{cost[last]:.3g}, {when}, and {cost[0]:.3g} at the start. With more time it may "
            "arrive."
        )
        return Finding("progress", text, float(history.times[last]), (name,))
    return None


def costs_in_words(history: History) -> str:
    """What is left of the goals that are followed, at the end."""
    left: list[str] = []
    for name, cost in history.costs.items():
        first, best, last = cost[0], cost.min(), cost[-1]
        left.append(f"{name} {last:.3g} (at the start {first:.3g}, at best {best:.3g})")
    return f"Cost at the end: {', '.join(left)}." if left else "There is no goal."


def _extent(history: History, since: int) -> float:
    """The largest share of its range in the episode that a component used from a step on."""
    span = np.ptp(history.state, axis=0)
    used = np.ptp(history.state[since:], axis=0)[span > 0] / span[span > 0]
    return float(used.max(initial=0.0))


def _last_low(cost: FloatArray) -> int:
    """The last step that brought a cost below all before it, by 2 % of its range or more."""
    step, least, last = 0, float(cost[0]), 0
    enough = 0.02 * float(np.ptp(cost))
    for step, value in enumerate(cost.tolist()):
        if value < least - enough:
            least, last = value, step
    return last if enough > 0 else 0


def _last_true(flags: BoolArray) -> int:
    """Index of the last true value; −1 if there is none."""
    true = np.flatnonzero(flags)
    return int(true[-1]) if len(true) else -1
