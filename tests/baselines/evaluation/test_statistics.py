"""What rows amount to, as numbers and as a table."""

from dataclasses import replace

from _inputs.comparison import POINTS, STEPS, handmade_rows

from aicon_baselines.evaluation.intervals import wilson_interval
from aicon_baselines.evaluation.statistics import summarize
from aicon_baselines.evaluation.tables import list_failures, to_table
from aicon_baselines.evaluation.task import Measure


def test_summary_of_handmade_rows() -> None:
    first, second = summarize(handmade_rows())
    assert (first.policy, first.episodes, first.successes, first.collisions) == ("a", 4, 3, 1)
    assert (first.success_rate, first.median_steps, first.median_path_ratio) == (0.75, 100, 1.5)
    assert first.interval == wilson_interval(3, 4)
    assert second.policy == "b" and second.success_rate == 0
    assert second.median_steps is None and second.median_path_ratio is None

    on_u = first.maps["u"]
    assert (on_u.episodes, on_u.collisions, on_u.success_rate) == (2, 1, 0.5)

    table = to_table([first, second], POINTS).splitlines()
    assert len(table) == 4
    assert table[2].startswith("| usual | a | 3/4 = 75.0% (30.1% to 95.4%) | 1 | 10.0 s | 1.50 |")


def test_summary_by_steps_of_handmade_rows() -> None:
    rows = [row._replace(shortest_path_length=None) for row in handmade_rows()]
    first, second = summarize(rows, STEPS.milestones)

    counts = [(each.steps, each.successes, each.success_rate) for each in first.milestones]
    assert counts == [(99, 0, 0.0), (100, 2, 0.5), (300, 3, 0.75)]
    assert first.milestones[1].interval == wilson_interval(2, 4)

    assert (first.median_steps, first.percentile_95_steps, first.longest_steps) == (100, 280, 300)
    assert second.median_steps is second.percentile_95_steps is second.longest_steps is None
    assert (first.failed_seeds, second.failed_seeds) == ([2], [0])
    assert first.median_path_ratio is None


def test_table_by_steps_of_handmade_rows() -> None:
    rows = [row._replace(shortest_path_length=None) for row in handmade_rows()]
    table = to_table(summarize(rows, STEPS.milestones), STEPS).splitlines()

    columns = "| within 100 steps | within 300 steps | median steps | 95th percentile | longest |"
    values = "| 50.0% (15.0% to 85.0%) | 75.0% (30.1% to 95.4%) | 100 | 280 | 300 |"
    assert table[0].endswith(columns)
    assert table[2].endswith(values)
    assert table[3].endswith(" |  |  |  |")


def test_what_a_task_measures_is_in_the_table() -> None:
    angle = Measure("angle", "angle", "{:.0f} deg", scale=10.0)
    gap = Measure("gap", "least gap", "{:.2f} px", least=True)
    task = replace(STEPS, measures=(angle, gap))
    rows = []
    for row in handmade_rows():
        rows.append(row._replace(measures={"angle": row.seed / 2, "gap": 3.0 - row.seed}))

    first, second = summarize(rows, task.milestones, task.measures)
    assert first.measures == {"angle": 0.5, "gap": 0.0}  # the successes have seeds 0, 1 and 3
    assert second.measures == {"angle": None, "gap": 3.0}
    assert "| within 10 s |" in to_table([first], replace(task, time_unit="s"))

    table = to_table([first, second], task).splitlines()
    assert table[0].endswith("| median distance at the end | angle | least gap |")
    assert table[2].endswith("| 0.1000 px | 5 deg | 0.00 px |")
    assert table[3].endswith("|  |  | 3.00 px |")


def test_failures_are_listed_where_there_are_few() -> None:
    rows = handmade_rows()
    many = [rows[-1]._replace(policy="c", seed=seed) for seed in range(21)]
    assert list_failures([*rows, *many], STEPS).splitlines() == [
        "usual, a: failed with seed 2 (collision)",
        "usual, b: failed with seed 0 (0.1 px left)",
    ]
    assert list_failures(rows[:2], POINTS) == ""
