"""The success curve: which share of the episodes has succeeded after which time."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from math import ceil, inf
from operator import attrgetter
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from aicon_baselines.evaluation.intervals import wilson_interval
from aicon_baselines.evaluation.row import Row
from aicon_baselines.evaluation.statistics import group_rows, median_of
from aicon_baselines.evaluation.task import Task
from aicon_baselines.extras import naming_extra
from aicon_baselines.files import replacing
from aicon_baselines.palette import CURVES

with naming_extra():
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.ticker import LogLocator, NullFormatter, PercentFormatter, StrMethodFormatter

_PANELS_PER_LINE = 3

STYLES = tuple((color, kind) for kind, color in product(("-", "--", ":", "-."), CURVES))
"""Colour and kind of a line, by its number; from the last on they begin again."""

_EVERYWHERE = (
    *("aicon", "paper_literal", "potential_field", "steepest"),
    *("diffusion", "sum_with_exploration", "ppo_sampled"),
)


@dataclass(frozen=True)
class SuccessCurve:
    """The successes of one policy over time.

    Attributes:
        policy: Name of the policy.
        times: (k,) the times at which an episode succeeded, increasing.
        shares: (k, 3) the share of episodes that had succeeded by then, and the ends of its 95 %
            Wilson interval.
        episodes: Number of episodes.
        median_time: Median time of the successes; infinite without any.
    """

    policy: str
    times: NDArray[np.float64]
    shares: NDArray[np.float64]
    episodes: int
    median_time: float

    @property
    def final_share(self) -> float:
        """The share of episodes that succeeded."""
        return float(self.shares[-1, 0]) if len(self.shares) else 0.0

    @property
    def rank(self) -> tuple[float, float, str]:
        """What orders curves as they end, from the top: most successes, then the shortest time."""
        return -self.final_share, self.median_time, self.policy


def success_curve(rows: Sequence[Row], time_step: float) -> SuccessCurve:
    """Return the share of episodes that had succeeded by each time at which one did.

    Args:
        rows: The n episodes of one policy.
        time_step: Duration of one step, in the unit that the times shall have.
    """
    steps = [row.steps for row in rows if row.steps is not None]
    moments, counts = np.unique(np.asarray(steps, np.float64), return_counts=True)

    shares = []
    for successes in np.cumsum(counts):
        interval = wilson_interval(int(successes), len(rows))
        shares.append((successes / len(rows), *interval))

    median_steps = median_of(steps)
    return SuccessCurve(
        policy=rows[0].policy,
        times=moments * time_step,
        shares=np.asarray(shares, np.float64).reshape(-1, 3),
        episodes=len(rows),
        median_time=inf if median_steps is None else median_steps * time_step,
    )


def draw_success_curves(rows: Sequence[Row], task: Task, path: Path) -> None:
    """Save a picture with one panel per condition and one line per policy.

    Bands are 95 % intervals, time is in log scale, and the legend beside a panel has the order in
    which its curves end.

    Args:
        rows: The episodes of all policies.
        task: The task; episodes end without success at its horizon, its last milestone is marked.
        path: Where to save the picture.
    """
    # A policy looks the same in all panels, and those of every task in all pictures.
    conditions = group_rows(rows, attrgetter("condition"))
    policies = (*_EVERYWHERE, *sorted({row.policy for row in rows}.difference(_EVERYWHERE)))
    styles = {name: STYLES[index % len(STYLES)] for index, name in enumerate(policies)}
    # The axis starts at the first success of any policy.
    start = min(row.steps or task.horizon / 2 for row in rows)

    # A panel for each condition, in lines of three.
    columns = min(len(conditions), _PANELS_PER_LINE)
    lines = ceil(len(conditions) / columns)
    figure = Figure(figsize=(7.5 * columns, 4.5 * lines), layout="constrained")
    panels = figure.subplots(lines, columns, squeeze=False).ravel()

    for axes, condition in zip(panels, sorted(conditions), strict=False):
        _prepare(axes, task, start)
        if len(conditions) > 1:
            axes.set_title(condition, loc="left")

        groups = group_rows(conditions[condition], attrgetter("policy"))
        curves = [success_curve(group, task.time_scale) for group in groups.values()]
        for curve in sorted(curves, key=attrgetter("rank")):
            _draw_curve(axes, curve, styles[curve.policy], task)
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)

    for axes in panels[len(conditions) :]:
        axes.set_axis_off()
    with replacing(path) as place:
        figure.savefig(place, dpi=160)


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
        time = steps * task.time_scale
        axes.axvline(time, color="0.5", linewidth=0.8)
        axes.text(time, 0.01, f" {task.duration(steps)}", color="0.5", fontsize="small")

    axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.yaxis.set_major_formatter(PercentFormatter(1))
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(alpha=0.25, linewidth=0.6)


def _draw_curve(axes: Axes, curve: SuccessCurve, style: tuple[str, str], task: Task) -> None:
    """Draw one policy, from a share of 0 at the first step to the horizon."""
    # Before the first success there is none, and after the last one nothing changes.
    nothing_yet = np.array([[0.0, *wilson_interval(0, curve.episodes)]])
    shares = np.concatenate([nothing_yet, curve.shares])
    shares = np.concatenate([shares, shares[-1:]])
    times = np.array([task.time_scale, *curve.times, task.horizon * task.time_scale])

    color, kind = style
    label = f"{curve.policy}  {curve.final_share:.1%}"
    axes.step(times, shares[:, 0], kind, where="post", color=color, linewidth=1.8, label=label)
    axes.fill_between(
        times, shares[:, 1], shares[:, 2], step="post", color=color, alpha=0.15, linewidth=0
    )
