"""A study of a policy's options: what each variant of it changes, episode by episode."""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from aicon_baselines.evaluation.row import Row
from aicon_baselines.evaluation.run_folder import RunFolder
from aicon_baselines.evaluation.statistics import Milestone, group_rows, median_of, reached_within
from aicon_baselines.evaluation.tables import to_markdown, to_percent, to_text
from aicon_baselines.evaluation.task import Task
from aicon_baselines.evaluation.variants import REFERENCE

_RESAMPLES = 5000


@dataclass(frozen=True)
class Difference:
    """Mean over episodes of what a variant has more than the reference, with its 95 % bootstrap interval."""

    mean: float
    interval: tuple[float, float]


@dataclass(frozen=True)
class Variant:
    """One variant, or the reference itself.

    Attributes:
        name: The variant as it was asked for.
        within: Successes within the task's last milestone; at the horizon if it has none.
        success: Successes at the horizon.
        median_steps: Median steps of the successes; None without any.
        within_difference: How much more often it succeeds within the milestone, as a share of the episodes.
        steps_difference: How many steps more it takes; an unsolved episode counts as the horizon.
    """

    name: str
    within: Milestone
    success: Milestone
    median_steps: float | None
    within_difference: Difference
    steps_difference: Difference


def evaluate(rows: Sequence[Row], names: Sequence[str], task: Task) -> list[Variant]:
    """Compare policies with the reference on the same episodes.

    Args:
        rows: The episodes of these policies and of the reference, those of each in the same order.
        names: Names of the policies.
        task: The task, with the horizon that the episodes had.
    """
    groups = group_rows(rows, lambda row: row.policy)
    return [_evaluate(groups[name], groups[REFERENCE], task) for name in names]


def write_study(task: Task, folder: RunFolder, names: Sequence[str]) -> str:
    """Write `study.json` and `study.png` into the folder and return the table, in Markdown."""
    task = folder.config.apply(task)
    variants = evaluate(folder.rows(), names, task)
    content = {"config": asdict(folder.config), "variants": [asdict(variant) for variant in variants]}
    (folder.path / "study.json").write_text(json.dumps(content, indent=2) + "\n")
    draw_study(variants, folder.path / "study.png")
    return _to_table(variants)


def bootstrap(differences: NDArray[np.float64]) -> Difference:
    """Return the mean of n paired differences and the middle 95 % of the means of n drawn from them, with repetition.

    (B. Efron, The Annals of Statistics 7, 1979.) Always the same draws, so that the numbers can be computed again.
    Where all n are equal the interval has no width, and says nothing about rarer episodes.
    """
    generator = np.random.default_rng(0)
    means = [generator.choice(differences, len(differences)).mean() for _ in range(_RESAMPLES)]
    low, high = np.quantile(means, [0.025, 0.975])
    return Difference(float(differences.mean()), (float(low), float(high)))


def draw_study(variants: Sequence[Variant], path: Path) -> None:
    """Save a picture of both differences, a line for each variant."""
    figure = Figure(figsize=(9.0, 1.2 + 0.3 * len(variants)), layout="constrained")
    FigureCanvasAgg(figure)
    left, right = figure.subplots(1, 2, sharey=True)
    _draw(left, [variant.within_difference for variant in variants], 100.0)
    _draw(right, [variant.steps_difference for variant in variants], 1.0)
    left.set_xlabel(f"success within {variants[0].within.steps} steps (points more)")
    right.set_xlabel("steps (more)")
    left.set_yticks(range(len(variants)), [variant.name for variant in variants])
    left.set_ylim(len(variants) - 0.5, -0.5)
    figure.savefig(path, dpi=160)


def _evaluate(rows: Sequence[Row], reference: Sequence[Row], task: Task) -> Variant:
    limit = task.milestones[-1] if task.milestones else task.horizon
    steps, reference_steps = _steps(rows, task.horizon), _steps(reference, task.horizon)
    within, reference_within = _within(rows, limit), _within(reference, limit)
    return Variant(
        name=rows[0].policy,
        within=reached_within(rows, limit),
        success=reached_within(rows, task.horizon),
        median_steps=median_of(row.steps for row in rows if row.steps is not None),
        within_difference=bootstrap(within - reference_within),
        steps_difference=bootstrap(steps - reference_steps),
    )


def _steps(rows: Sequence[Row], horizon: int) -> NDArray[np.float64]:
    return np.array([horizon if row.steps is None else row.steps for row in rows], np.float64)


def _within(rows: Sequence[Row], limit: int) -> NDArray[np.float64]:
    return np.array([row.steps is not None and row.steps <= limit for row in rows], np.float64)


def _to_table(variants: Sequence[Variant]) -> str:
    within = f"within {variants[0].within.steps} steps"
    header = ["variant", within, "at the horizon", "median steps", f"{within}, more (points)", "steps, more"]
    return to_markdown(header, map(_cells, variants))


def _cells(variant: Variant) -> list[str]:
    return [
        variant.name,
        to_percent(variant.within.success_rate, variant.within.interval),
        to_percent(variant.success.success_rate, variant.success.interval),
        to_text(variant.median_steps, "{:g}"),
        _to_interval(variant.within_difference, 100.0),
        _to_interval(variant.steps_difference, 1.0),
    ]


def _to_interval(difference: Difference, scale: float) -> str:
    mean, (low, high) = difference.mean, difference.interval
    return f"{scale * mean:+.1f} ({scale * low:+.1f} to {scale * high:+.1f})"


def _draw(axes: Axes, differences: Sequence[Difference], scale: float) -> None:
    middle = scale * np.array([difference.mean for difference in differences])
    ends = scale * np.array([difference.interval for difference in differences])
    axes.axvline(0.0, color="0.5", linewidth=0.8)
    axes.errorbar(middle, range(len(middle)), xerr=np.abs(ends.T - middle), fmt="o", color="#0072B2", markersize=4)
    low, high = axes.get_xlim()
    axes.set_xlim(min(low, -1.0), max(high, 1.0))  # no picture of rounding where nothing differs
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(axis="x", alpha=0.25, linewidth=0.6)
