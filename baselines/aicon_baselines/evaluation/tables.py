"""The rows and summaries of a comparison as text, in Markdown."""

from collections.abc import Callable, Iterable, Sequence
from functools import partial

from aicon_baselines.evaluation.row import Row
from aicon_baselines.evaluation.statistics import Summary, group_rows
from aicon_baselines.evaluation.task import Measure, Task

_FEW = 20  # failures of one policy that are still listed


def to_table(summaries: Iterable[Summary], task: Task) -> str:
    """Write the summaries as a table, with the columns that the task has values for."""
    columns = _columns(task)
    return to_markdown(list(columns), ([text(summary) for text in columns.values()] for summary in summaries))


def list_failures(rows: Iterable[Row], task: Task) -> str:
    """Name the failed episodes of each policy that has few, a line for each policy."""
    lines = []
    for (condition, policy), group in sorted(group_rows(rows, lambda row: (row.condition, row.policy)).items()):
        failures = [row for row in group if not row.success]
        if 0 < len(failures) <= _FEW:
            seeds = (f"{row.seed} ({_reason(row, task.length_unit)})" for row in failures)
            lines.append(f"{condition}, {policy}: failed with seed {', '.join(seeds)}")
    return "\n".join(lines)


def to_markdown(header: Sequence[str], lines: Iterable[Sequence[str]]) -> str:
    """Write cells as a table."""
    first, *others = (f"| {' | '.join(cells)} |" for cells in (header, *lines))
    return "\n".join((first, "|---" * len(header) + "|", *others))


def to_text(value: float | None, form: str, scale: float = 1.0) -> str:
    """Write `value * scale` in a format such as "{:.1f} s"; nothing for None."""
    return "" if value is None else form.format(value * scale)


def to_percent(rate: float, interval: tuple[float, float]) -> str:
    """Write a share with its interval."""
    low, high = interval
    return f"{rate:.1%} ({low:.1%} to {high:.1%})"


def _columns(task: Task) -> dict[str, Callable[[Summary], str]]:
    """Return what each column says about a summary."""
    columns: dict[str, Callable[[Summary], str]] = {
        "condition": lambda summary: summary.condition,
        "policy": lambda summary: summary.policy,
        "success (95 % interval)": _success,
    }
    for index, steps in enumerate(task.milestones):
        columns[f"within {task.duration(steps)}"] = partial(_milestone, index)
    if task.shortest_path_length or task.measures:
        columns["collisions"] = lambda summary: str(summary.collisions)
    if task.time_unit == "s":
        columns["median time"] = lambda summary: to_text(summary.median_steps, "{:.1f} s", task.time_step)
    else:
        columns["median steps"] = lambda summary: to_text(summary.median_steps, "{:g}")
        columns["95th percentile"] = lambda summary: to_text(summary.percentile_95_steps, "{:.0f}")
        columns["longest"] = lambda summary: to_text(summary.longest_steps, "{:g}")
    if task.shortest_path_length:
        columns["median path / shortest"] = lambda summary: to_text(summary.median_path_ratio, "{:.2f}")
    if task.measures:
        form = f"{{:.4f}} {task.length_unit}"
        columns["median distance at the end"] = lambda summary: to_text(summary.median_distance, form)
    for measure in task.measures:
        columns[measure.title] = partial(_measure, measure)
    return columns


def _success(summary: Summary) -> str:
    percent = to_percent(summary.success_rate, summary.interval)
    return f"{summary.successes}/{summary.episodes} = {percent}"


def _milestone(index: int, summary: Summary) -> str:
    milestone = summary.milestones[index]
    return to_percent(milestone.success_rate, milestone.interval)


def _measure(measure: Measure, summary: Summary) -> str:
    return to_text(summary.measures[measure.key], measure.form, measure.scale)


def _reason(row: Row, unit: str) -> str:
    return "collision" if row.collision else f"{row.distance:.3g} {unit} left"
