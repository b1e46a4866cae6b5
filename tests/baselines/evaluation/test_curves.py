"""The success curves and the files of a report."""

import json
from pathlib import Path

import numpy as np
import pytest
from _inputs.comparison import POINTS, STEPS, handmade_rows, rows_by_steps
from matplotlib.figure import Figure

from aicon_baselines.evaluation.config import configure
from aicon_baselines.evaluation.curves import STYLES, draw_success_curves, success_curve
from aicon_baselines.evaluation.intervals import wilson_interval
from aicon_baselines.evaluation.report import write_report
from aicon_baselines.evaluation.row import Row
from aicon_baselines.evaluation.run_folder import RunFolder
from aicon_baselines.evaluation.statistics import summarize
from aicon_baselines.evaluation.tables import to_table
from aicon_baselines.evaluation.task import Task


def test_success_curve_of_handmade_rows() -> None:
    curve = success_curve(handmade_rows()[:4], time_step=0.1)
    np.testing.assert_allclose(curve.times, [10.0, 30.0])
    expected = [[0.5, *wilson_interval(2, 4)], [0.75, *wilson_interval(3, 4)]]
    np.testing.assert_allclose(curve.shares, expected)
    assert (curve.policy, curve.final_share, curve.median_time) == ("a", 0.75, 10.0)


def test_a_policy_without_success_has_a_curve_without_points() -> None:
    curve = success_curve(handmade_rows()[4:], time_step=0.1)
    assert curve.times.shape == (0,) and curve.shares.shape == (0, 3)
    assert (curve.final_share, curve.median_time) == (0.0, np.inf)


def legend_of(rows: list[Row], folder: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The names in the legend of the curves."""
    figures: list[Figure] = []
    save = Figure.savefig

    def watched_save(figure: Figure, path: Path, **options: float) -> None:
        figures.append(figure)
        save(figure, path, **options)

    monkeypatch.setattr(Figure, "savefig", watched_save)
    draw_success_curves(rows, STEPS, folder / "curves.png")

    (figure,) = figures
    legend = figure.axes[0].get_legend()
    assert legend is not None
    return [text.get_text().split("  ")[0] for text in legend.get_texts()]


def test_the_legend_has_the_order_in_which_the_curves_end(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rows = [
        *rows_by_steps("a fails", [None, None]),
        *rows_by_steps("b is late", [300, 300]),
        *rows_by_steps("c is early", [200, 200]),
        *rows_by_steps("d does half", [100, None]),
    ]
    names = legend_of(rows, tmp_path, monkeypatch)
    assert names == ["c is early", "b is late", "d does half", "a fails"]


def test_no_two_policies_look_the_same() -> None:
    assert len({color for color, _ in STYLES[:7]}) == 7
    assert len(set(STYLES)) == len(STYLES) == 28


@pytest.mark.parametrize(
    ("rows", "task"),
    [(handmade_rows(), POINTS), (handmade_rows()[4:], STEPS)],
    ids=["some succeed, in seconds", "none succeeds, in steps"],
)
def test_report_files(tmp_path: Path, rows: list[Row], task: Task) -> None:
    # More than one line of panels.
    rows = [*rows, *(rows[0]._replace(condition=name) for name in ("w", "x", "y"))]
    with RunFolder.open(tmp_path, configure(task, episodes=4)) as folder:
        folder.append(rows)
        table = write_report(task, folder)

    assert table == to_table(summarize(rows, task.milestones), task)
    assert (tmp_path / "success_curve.png").read_bytes().startswith(b"\x89PNG")

    content = json.loads((tmp_path / "summary.json").read_text())
    assert content["config"]["episodes"] == 4
    first = content["summaries"][0]
    same = [row for row in rows if (row.condition, row.policy) == ("usual", first["policy"])]
    assert first["maps"]["u"]["episodes"] == sum(row.map == "u" for row in same)
