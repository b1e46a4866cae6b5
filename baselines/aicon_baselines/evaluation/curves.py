"""The success curve: which share of the episodes has succeeded after which time."""

from collections.abc import Sequence
from itertools import pairwise
from math import ceil
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter, PercentFormatter, StrMethodFormatter
from numpy.typing import NDArray

from aicon_baselines.evaluation.intervals import wilson_interval
from aicon_baselines.evaluation.row import Row
from aicon_baselines.evaluation.statistics import group_rows
from aicon_baselines.evaluation.task import Task

# Colours that colour-blind readers can tell apart (Okabe and Ito, "Color Universal Design", 2008); beyond seven
# policies they come back with another line style.
_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
_LINE_STYLES = ("-", "--", ":", "-.")
_COLUMNS = 3  # panels next to each other
_LABEL_DISTANCE = 0.05  # least distance of two labels, as a share of episodes


def success_curve(rows: Sequence[Row], time_step: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the share of episodes that had succeeded by each time at which one did.

    Args:
        rows: The n episodes of one policy.
        time_step: Duration of one step.

    Returns:
        Times (k,), in the unit of `time_step`, and for each the share and the ends of its 95 % Wilson interval (k, 3).
    """
    steps, counts = np.unique([row.steps for row in rows if row.steps is not None], return_counts=True)
    successes = np.cumsum(counts)
    shares = [(count / len(rows), *wilson_interval(int(count), len(rows))) for count in successes]
    return np.asarray(steps, np.float64) * time_step, np.asarray(shares, np.float64).reshape(-1, 3)


def draw_success_curves(rows: Sequence[Row], task: Task, path: Path) -> None:
    """Save a picture with one panel per condition and one labelled line per policy, bands of 95 %, time in log scale.

    Args:
        rows: The episodes of all policies.
        task: The task; episodes end without success at its horizon, its last milestone is marked.
        path: Where to save the picture.
    """
    conditions = group_rows(rows, lambda row: row.condition)
    columns = min(len(conditions), _COLUMNS)
    lines = ceil(len(conditions) / columns)
    figure = Figure(figsize=(7.5 * columns, 4.5 * lines), layout="constrained")
    FigureCanvasAgg(figure)
    start = min(row.steps or task.horizon / 2 for row in rows)
    policies = sorted({row.policy for row in rows})
    panels = figure.subplots(lines, columns, squeeze=False).ravel()
    for axes, (condition, group) in zip(panels, sorted(conditions.items()), strict=False):
        _prepare(axes, task, start)
        if len(conditions) > 1:
            axes.set_title(condition, loc="left")
        groups = group_rows(group, lambda row: row.policy)
        shares = {policy: _draw(axes, groups[policy], policies.index(policy), task) for policy in groups}
        for policy, height in _spread(shares).items():
            text = f"{policy}  {shares[policy]:.1%}"
            colour, _ = _style(policies.index(policy))
            axes.annotate(text, (1.01, height), xycoords=("axes fraction", "data"), color=colour, va="center")
    for axes in panels[len(conditions) :]:
        axes.set_axis_off()
    figure.savefig(path, dpi=160)


def _prepare(axes: Axes, task: Task, start: float) -> None:
    """Set up a panel from `start`, in steps, to the horizon."""
    axes.set(
        xscale="log",
        xlim=(start * task.time_scale, task.horizon * task.time_scale),
        ylim=(0, 1.02),
        xlabel=f"time ({task.time_unit})",
        ylabel="episodes that reached the target",
    )
    for steps in task.milestones[-1:]:
        axes.axvline(steps * task.time_scale, color="0.5", linewidth=0.8)
        axes.text(steps * task.time_scale, 0.01, f" {task.duration(steps)}", color="0.5", fontsize="small")
    axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.yaxis.set_major_formatter(PercentFormatter(1))
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(alpha=0.25, linewidth=0.6)


def _draw(axes: Axes, rows: Sequence[Row], index: int, task: Task) -> float:
    """Draw one policy, from a share of 0 at the first step to the horizon, and return its final share."""
    times, shares = success_curve(rows, task.time_scale)
    before = np.array([[0, *wilson_interval(0, len(rows))]])
    shares = np.concatenate([before, shares, shares[-1:] if len(shares) else before])
    times = np.concatenate([[task.time_scale], times, [task.horizon * task.time_scale]])
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
