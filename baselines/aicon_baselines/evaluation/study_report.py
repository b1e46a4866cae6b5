"""The results of a study: `study.json`, `study.png` and a table."""

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np

from aicon_baselines.evaluation.run_folder import RunFolder
from aicon_baselines.evaluation.study import Difference, Variant, evaluate
from aicon_baselines.evaluation.tables import to_markdown, to_percent, to_text
from aicon_baselines.evaluation.task import Task
from aicon_baselines.extras import missing_extra
from aicon_baselines.files import replacing, write_json

try:
    from matplotlib.axes import Axes
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
except ModuleNotFoundError as error:
    raise missing_extra(error) from error


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


def draw_study(variants: Sequence[Variant], path: Path) -> None:
    """Save a picture of both differences, a line for each variant."""
    figure = Figure(figsize=(9.0, 1.2 + 0.3 * len(variants)), layout="constrained")
    FigureCanvasAgg(figure)
    left, right = figure.subplots(1, 2, sharey=True)

    # Successes on the left, as percentage points.
    more_successes = [variant.within_difference for variant in variants]
    _draw(left, more_successes, scale=100.0)
    left.set_xlabel(f"success within {variants[0].within.steps} steps (points more)")

    # Steps on the right.
    more_steps = [variant.steps_difference for variant in variants]
    _draw(right, more_steps, scale=1.0)
    right.set_xlabel("steps (more)")

    # A line for each variant, from the top.
    left.set_yticks(range(len(variants)), [variant.name for variant in variants])
    left.set_ylim(len(variants) - 0.5, -0.5)
    with replacing(path) as place:
        figure.savefig(place, dpi=160)


def _draw(axes: Axes, differences: Sequence[Difference], scale: float) -> None:
    """Draw the mean and the interval of each difference, times `scale`."""
    means = scale * np.array([difference.mean for difference in differences])
    intervals = scale * np.array([difference.interval for difference in differences])
    bars = np.abs(intervals.T - means)

    axes.axvline(0.0, color="0.5", linewidth=0.8)
    axes.errorbar(means, range(len(means)), xerr=bars, fmt="o", color="#0072B2", markersize=4)

    # Where nothing differs, the axis would show the rounding.
    low, high = axes.get_xlim()
    axes.set_xlim(min(low, -1.0), max(high, 1.0))
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(axis="x", alpha=0.25, linewidth=0.6)


def _to_table(variants: Sequence[Variant]) -> str:
    within = f"within {variants[0].within.steps} steps"
    header = [
        "variant",
        within,
        "at the horizon",
        "median steps",
        f"{within}, more (points)",
        "steps, more",
    ]
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
    mean = scale * difference.mean
    low, high = (scale * end for end in difference.interval)
    return f"{mean:+.1f} ({low:+.1f} to {high:+.1f})"
