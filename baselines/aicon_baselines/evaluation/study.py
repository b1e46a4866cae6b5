"""A study of a policy's options: what each variant of it changes, episode by episode."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from operator import attrgetter
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from aicon_baselines.evaluation.intervals import bootstrap_interval
from aicon_baselines.evaluation.row import Row
from aicon_baselines.evaluation.run_folder import RunFolder
from aicon_baselines.evaluation.statistics import (
    Milestone,
    group_rows,
    median_of,
    reached_within,
)
from aicon_baselines.evaluation.tables import to_markdown, to_percent, to_text
from aicon_baselines.evaluation.task import Task
from aicon_baselines.extras import naming_extra
from aicon_baselines.files import replacing, write_json
from aicon_baselines.palette import ROBOT

with naming_extra():
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Difference:
    """Mean over episodes of what a variant has more than the reference, with its 95 % interval."""

    mean: float
    interval: tuple[float, float]

    def __str__(self) -> str:
        """The mean and the interval, such as "+1.5 (+0.2 to +2.9)"."""
        low, high = self.interval
        return f"{self.mean:+.1f} ({low:+.1f} to {high:+.1f})"

    def scaled(self, scale: float) -> "Difference":
        """The same in another unit."""
        low, high = self.interval
        return Difference(scale * self.mean, (scale * low, scale * high))


@dataclass(frozen=True)
class Variant:
    """One variant, or the reference itself.

    Attributes:
        name: The variant as it was asked for.
        within: Successes within the task's last milestone; at the horizon if it has none.
        success: Successes at the horizon.
        median_steps: Median steps of the successes; None without any.
        within_difference: How much more often it succeeds within the milestone, as a share of the
            episodes.
        steps_difference: How many steps more it takes; an unsolved episode counts as the horizon.
    """

    name: str
    within: Milestone
    success: Milestone
    median_steps: float | None
    within_difference: Difference
    steps_difference: Difference


def write_study(task: Task, folder: RunFolder, names: Sequence[str]) -> str:
    """Write `study.json` and `study.png` into the folder and return the table, in Markdown.

    Args:
        task: The task.
        folder: The folder, with the rows of all variants.
        names: Names of the variants, the reference first.
    """
    task = folder.config.apply(task)
    variants = evaluate(folder.rows(), names, task)

    content = {
        "config": asdict(folder.config),
        "variants": [asdict(variant) for variant in variants],
    }
    write_json(folder.path / "study.json", content)

    draw_study(variants, folder.path / "study.png")
    return _to_table(variants)


def evaluate(rows: Sequence[Row], names: Sequence[str], task: Task) -> list[Variant]:
    """Compare policies with a reference on the same episodes.

    Args:
        rows: The episodes of these policies, those of each in the same order.
        names: Names of the policies, the reference first.
        task: The task, with the horizon that the episodes had.
    """
    groups = group_rows(rows, attrgetter("policy"))
    reference = groups[names[0]]
    return [_compare(groups[name], reference, task) for name in names]


def mean_difference(differences: NDArray[np.float64]) -> Difference:
    """Return the mean of paired differences (n,) with its bootstrap interval."""
    return Difference(float(differences.mean()), bootstrap_interval(differences))


def _compare(rows: Sequence[Row], reference: Sequence[Row], task: Task) -> Variant:
    limit = task.milestones[-1] if task.milestones else task.horizon
    more_steps = _steps(rows, task.horizon) - _steps(reference, task.horizon)
    more_successes = _within(rows, limit) - _within(reference, limit)

    # Pair by pair: the same episode of the variant and of the reference.
    return Variant(
        name=rows[0].policy,
        within=reached_within(rows, limit),
        success=reached_within(rows, task.horizon),
        median_steps=median_of(row.steps for row in rows if row.steps is not None),
        within_difference=mean_difference(more_successes),
        steps_difference=mean_difference(more_steps),
    )


def _steps(rows: Sequence[Row], horizon: int) -> NDArray[np.float64]:
    """Return the steps that each episode took, (n,); an unsolved one took all."""
    steps = [horizon if row.steps is None else row.steps for row in rows]
    return np.array(steps, np.float64)


def _within(rows: Sequence[Row], limit: int) -> NDArray[np.float64]:
    """Return 1 for each episode that succeeded in so many steps and 0 for the others, (n,)."""
    succeeded = [row.steps is not None and row.steps <= limit for row in rows]
    return np.array(succeeded, np.float64)


def draw_study(variants: Sequence[Variant], path: Path) -> None:
    """Save a picture of both differences, a line for each variant."""
    figure = Figure(figsize=(9.0, 1.2 + 0.3 * len(variants)), layout="constrained")
    left, right = figure.subplots(1, 2, sharey=True)

    # Successes on the left, as percentage points; steps on the right.
    _draw(left, [variant.within_difference.scaled(100.0) for variant in variants])
    left.set_xlabel(f"success within {variants[0].within.steps} steps (points more)")
    _draw(right, [variant.steps_difference for variant in variants])
    right.set_xlabel("steps (more)")

    # A line for each variant, from the top.
    left.set_yticks(range(len(variants)), [variant.name for variant in variants])
    left.set_ylim(len(variants) - 0.5, -0.5)
    with replacing(path) as place:
        figure.savefig(place, dpi=160)


def _draw(axes: Axes, differences: Sequence[Difference]) -> None:
    """Draw the mean and the interval of each difference."""
    means = np.array([difference.mean for difference in differences])
    intervals = np.array([difference.interval for difference in differences])
    bars = np.abs(intervals.T - means)

    axes.axvline(0.0, color="0.5", linewidth=0.8)
    axes.errorbar(means, range(len(means)), xerr=bars, fmt="o", color=ROBOT, markersize=4)

    # Where nothing differs, the axis would show the rounding.
    low, high = axes.get_xlim()
    axes.set_xlim(min(low, -1.0), max(high, 1.0))
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(axis="x", alpha=0.25, linewidth=0.6)


def _to_table(variants: Sequence[Variant]) -> str:
    within = f"within {variants[0].within.steps} steps"
    header = ["variant", within, "at the horizon", "median steps"]
    header += [f"{within}, more (points)", "steps, more"]

    lines = []
    for variant in variants:
        lines.append(
            [
                variant.name,
                to_percent(variant.within.success_rate, variant.within.interval),
                to_percent(variant.success.success_rate, variant.success.interval),
                to_text(variant.median_steps, "{:g}"),
                str(variant.within_difference.scaled(100.0)),
                str(variant.steps_difference),
            ]
        )
    return to_markdown(header, lines)
