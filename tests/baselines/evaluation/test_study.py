"""Studies: variants compared with the reference, episode by episode."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from _inputs.comparison import POINTS, rows_by_steps

from aicon_baselines.evaluation.config import configure
from aicon_baselines.evaluation.run_folder import RunFolder
from aicon_baselines.evaluation.study import evaluate, mean_difference, write_study


def test_differences_are_paired() -> None:
    task = replace(POINTS, horizon=1000, milestones=(300,))
    rows = [
        *rows_by_steps("aicon", [100, 200, 400, None]),
        *rows_by_steps("margin=0.0", [90, 310, None, None]),
    ]
    reference, variant = evaluate(rows, ["aicon", "margin=0.0"], task)

    assert (reference.within.success_rate, reference.success.success_rate) == (0.5, 0.75)
    assert reference.median_steps == 200
    assert reference.within_difference.mean == 0
    assert reference.steps_difference.interval == (0, 0)

    assert (variant.within.success_rate, variant.success.success_rate) == (0.25, 0.5)
    assert variant.median_steps == 200
    assert variant.within_difference.mean == -0.25
    assert variant.steps_difference.mean == np.mean([-10, 110, 600, 0])


def test_a_difference_is_the_mean_with_its_interval() -> None:
    difference = mean_difference(np.array([1.0, 2.0, 6.0]))
    low, high = difference.interval
    assert difference.mean == 3.0 and 1.0 <= low < 3.0 < high <= 6.0


@pytest.mark.parametrize("milestones", [(), (300,)])
def test_study_files(tmp_path: Path, milestones: tuple[int, ...]) -> None:
    task = replace(POINTS, horizon=12_000, milestones=milestones)
    with RunFolder.open(tmp_path, configure(task, episodes=2)) as folder:
        folder.append(rows_by_steps("aicon", [100, 200]))
        folder.append(rows_by_steps("margin=0.0", [None, None]))
        folder.append(rows_by_steps("from an earlier run", [1, 2]))
        table = write_study(task, folder, ["aicon", "margin=0.0"]).splitlines()

    assert len(table) == 4
    difference = "-100.0 (-100.0 to -100.0) | +11850.0 (+11800.0 to +11900.0)"
    assert table[3].endswith(f"| 0.0% (0.0% to 65.8%) |  | {difference} |")

    content = json.loads((tmp_path / "study.json").read_text())
    assert [each["name"] for each in content["variants"]] == ["aicon", "margin=0.0"]
    assert content["variants"][1]["steps_difference"]["mean"] == 11850
    assert (tmp_path / "study.png").read_bytes().startswith(b"\x89PNG")
