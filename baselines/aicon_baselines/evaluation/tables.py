"""The rows and summaries of a comparison as text, in Markdown."""

from collections.abc import Iterable, Sequence
from operator import attrgetter

from aicon_baselines.evaluation.row import Row
from aicon_baselines.evaluation.statistics import Summary, group_rows
from aicon_baselines.evaluation.task import Task

_MOST_LISTED = 20  # failures of one policy that are still listed


def to_table(summaries: Iterable[Summary], task: Task) -> str:
    """Write the summaries as a table, with the columns that the task has values for."""
    lines = [_cells(summary, task) for summary in summaries]
    header = list(lines[0]) if lines else []
    return to_markdown(header, [list(line.values()) for line in lines])


def list_failures(rows: Iterable[Row], task: Task) -> str:
    """Name the failed episodes of each policy that has few, a line for each policy."""
    lines = []
    groups = group_rows(rows, attrgetter("condition", "policy"))
    for (condition, policy), group in sorted(groups.items()):
        failures = [row for row in group if not row.success]

        if 0 < len(failures) <= _MOST_LISTED:
            seeds = ", ".join(f"{row.seed} ({_reason(row, task)})" for row in failures)
            lines.append(f"{condition}, {policy}: failed with seed {seeds}")

    return "\n".join(lines)


def to_markdown(header: Sequence[str], lines: Iterable[Sequence[str]]) -> str:
    """Write cells as a table."""
    table = [f"| {' | '.join(header)} |", "|---" * len(header) + "|"]
    for cells in lines:
        table.append(f"| {' | '.join(cells)} |")
    return "\n".join(table)


def to_text(value: float | None, form: str, scale: float = 1.0) -> str:
    """Write `value * scale` in a format such as "{:.1f} s"; nothing for None."""
    return "" if value is None else form.format(value * scale)


def to_percent(rate: float, interval: tuple[float, float]) -> str:
    """Write a share with its interval."""
    low, high = interval
    return f"{rate:.1%} ({low:.1%} to {high:.1%})"


def _cells(summary: Summary, task: Task) -> dict[str, str]:
    """Return what the line of a summary says, by the heading of the column."""
    # Whose episodes, and how many succeeded, in all and in fewer steps.
    success = to_percent(summary.success_rate, summary.interval)
    cells = {
        "condition": summary.condition,
        "policy": summary.policy,
        "success (95 % interval)": f"{summary.successes}/{summary.episodes} = {success}",
    }
    for milestone in summary.milestones:
        share = to_percent(milestone.success_rate, milestone.interval)
        cells[f"within {task.duration(milestone.steps)}"] = share

    # Collisions mean something where there are obstacles, or joints that are measured.
    if task.shortest_path_length or task.measures:
        cells["collisions"] = str(summary.collisions)

    # Time, of the successes.
    if task.time_unit == "s":
        cells["median time"] = to_text(summary.median_steps, "{:.1f} s", task.time_step)
    else:
        cells["median steps"] = to_text(summary.median_steps, "{:g}")
        cells["95th percentile"] = to_text(summary.percentile_95_steps, "{:.0f}")
        cells["longest"] = to_text(summary.longest_steps, "{:g}")

    # Lengths, and what else is measured.
    if task.shortest_path_length:
        cells["median path / shortest"] = to_text(summary.median_path_ratio, "{:.2f}")
    if task.measures:
        distance = to_text(summary.median_distance, f"{{:.4f}} {task.length_unit}")
        cells["median distance at the end"] = distance
    for measure in task.measures:
        cells[measure.title] = to_text(summary.measures[measure.key], measure.form, measure.scale)
    return cells


def _reason(row: Row, task: Task) -> str:
    """Say why an episode failed."""
    return "collision" if row.collision else f"{row.distance:.3g} {task.length_unit} left"
