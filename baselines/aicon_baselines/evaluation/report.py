"""The results of a run folder: `summary.json`, `success_curve.png` and a table."""

from dataclasses import asdict

from aicon_baselines.evaluation.curves import draw_success_curves
from aicon_baselines.evaluation.run_folder import RunFolder
from aicon_baselines.evaluation.statistics import summarize
from aicon_baselines.evaluation.tables import to_table
from aicon_baselines.evaluation.task import Task
from aicon_baselines.files import write_json


def write_report(task: Task, folder: RunFolder) -> str:
    """Write `summary.json` and `success_curve.png`, and return the table, in Markdown."""
    rows, config = folder.rows(), folder.config
    task = config.apply(task)
    summaries = summarize(rows, task.milestones, task.measures)

    content = {
        "config": asdict(config),
        "summaries": [asdict(summary) for summary in summaries],
    }
    write_json(folder.path / "summary.json", content)

    draw_success_curves(rows, task, folder.path / "success_curve.png")
    return to_table(summaries, task)
