"""The success curve: which share of the episodes has succeeded after which time."""

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter, PercentFormatter, StrMethodFormatter
from numpy.typing import NDArray

from aicon_baselines.intervals import wilson_interval
from aicon_baselines.row import Row
from aicon_baselines.summary import group_rows

# Colours that colour-blind readers can tell apart (Okabe and Ito, "Color Universal Design", 2008); beyond seven
# policies they come back with another line style.
_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
_LINE_STYLES = ("-", "--", ":", "-.")
_LABEL_DISTANCE = 0.05  # least distance of two labels, as a share of episodes


def success_curve(rows: Sequence[Row], time_step: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the share of episodes that had succeeded by each time at which one did.

    Args:
        rows: The n episodes of one policy.
        time_step: Duration of one step, s.

    Returns:
        Times (k,), s, and for each the share and the ends of its 95 % Wilson interval (k, 3).
    """
    steps, counts = np.unique([row.steps for row in rows if row.steps is not None], return_counts=True)
    successes = np.cumsum(counts)
    shares = [(count / len(rows), *wilson_interval(int(count), len(rows))) for count in successes]
    return np.asarray(steps, np.float64) * time_step, np.asarray(shares, np.float64).reshape(-1, 3)


def draw_success_curves(rows: Sequence[Row], time_step: float, horizon: int, path: Path) -> None:
    """Save a picture with one panel per condition and one labelled line per policy, bands of 95 %, time in log scale.

    Args:
        rows: The episodes of all policies.
        time_step: Duration of one step, s.
        horizon: Steps after which an episode ends without success.
        path: Where to save the picture.
    """
    conditions = group_rows(rows, lambda row: row.condition)
    figure = Figure(figsize=(7.5 * len(conditions), 4.5), layout="constrained")
    FigureCanvasAgg(figure)
    end = horizon * time_step
    start = min(row.steps or horizon / 2 for row in rows) * time_step
    policies = sorted({row.policy for row in rows})
    panels = figure.subplots(1, len(conditions), squeeze=False)[0]
    for axes, (condition, group) in zip(panels, sorted(conditions.items()), strict=True):
        _prepare(axes, start, end)
        if len(conditions) > 1:
            axes.set_title(condition, loc="left")
        lines = group_rows(group, lambda row: row.policy)
        shares = {policy: _draw(axes, lines[policy], policies.index(policy), time_step, end) for policy in lines}
        for policy, height in _spread(shares).items():
            text = f"{policy}  {shares[policy]:.1%}"
            colour, _ = _style(policies.index(policy))
            axes.annotate(text, (1.01, height), xycoords=("axes fraction", "data"), color=colour, va="center")
    figure.savefig(path, dpi=160)


def _prepare(axes: Axes, start: float, end: float) -> None:
    axes.set(
        xscale="log", xlim=(start, end), ylim=(0, 1.02), xlabel="time (s)", ylabel="episodes that reached the target"
    )
    axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.yaxis.set_major_formatter(PercentFormatter(1))
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(alpha=0.25, linewidth=0.6)


def _draw(axes: Axes, rows: Sequence[Row], index: int, time_step: float, end: float) -> float:
    """Draw one policy, from a share of 0 at the first step to the horizon, and return its final share."""
    times, shares = success_curve(rows, time_step)
    before = np.array([[0, *wilson_interval(0, len(rows))]])
    shares = np.concatenate([before, shares, shares[-1:] if len(shares) else before])
    times = np.concatenate([[time_step], times, [end]])
    colour, line_style = _style(index)
    axes.step(times, shares[:, 0], where="post", color=colour, linestyle=line_style, linewidth=1.8)
    axes.fill_between(times, shares[:, 1], shares[:, 2], step="post", color=colour, alpha=0.15, linewidth=0)
    return float(shares[-1, 0])


def _style(index: int) -> tuple[str, str]:
    return _COLOURS[index % len(_COLOURS)], _LINE_STYLES[index // len(_COLOURS) % len(_LINE_STYLES)]


def _spread(heights: dict[str, float]) -> dict[str, float]:
    """Move labels apart: upward from the lowest, then downward from 100 %."""
    names = sorted(heights, key=lambda name: heights[name])
    spread = dict(heights)
    for below, name in pairwise(names):
        spread[name] = max(spread[name], spread[below] + _LABEL_DISTANCE)
    limit = 1.0
    for name in reversed(names):
        spread[name] = min(spread[name], limit)
        limit = spread[name] - _LABEL_DISTANCE
    return spread
