"""What a comparison is made for, and the files of its folder."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from _inputs.comparison import POINTS, STEPS, handmade_rows

from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.evaluation.config import configure
from aicon_baselines.evaluation.row import Row
from aicon_baselines.evaluation.run_folder import RunFolder


def test_another_configuration_is_refused(tmp_path: Path) -> None:
    config = configure(POINTS, episodes=4)
    RunFolder(tmp_path, config)
    RunFolder(tmp_path, config)

    message = "another comparison: episodes is 4 there and 5 here; seed is 0 there and 1"
    with pytest.raises(ComparisonError, match=message):
        RunFolder(tmp_path, replace(config, episodes=5, seed=1))


def test_broken_files_are_refused(tmp_path: Path) -> None:
    folder = RunFolder(tmp_path, configure(POINTS))
    folder.append(handmade_rows())
    path = tmp_path / "episodes.csv"

    path.write_text(path.read_text().replace("300", "many"))
    with pytest.raises(ComparisonError, match="line 3 is not a row"):
        folder.rows()

    path.write_text("a,b\n1,2\n")
    with pytest.raises(ComparisonError, match="expected .'policy'"):
        folder.rows()


def test_rows_come_back_from_their_text() -> None:
    for row in handmade_rows():
        measured = row._replace(shortest_path_length=None, measures={"angle": 0.5, "gap": -1.0})
        assert Row.from_fields(row.to_fields()) == row
        assert Row.from_fields(measured.to_fields()) == measured


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"episodes": 0}, "episodes must be 1 or more, not 0"),
        ({"repeats": 0}, "repeats must be 1 or more"),
        ({"horizon": 0}, "horizon must be 1 or more"),
        ({"seed": -1}, "seed must be 0 or more, not -1"),
        ({"maps": ["stormy"]}, "unknown map 'stormy'; valid maps: calm, windy$"),
        (
            {"conditions": ["odd"]},
            "unknown condition 'odd'; valid conditions: usual, other",
        ),
        (
            {"conditions": ["usual", "other"], "repeats": 2},
            "repeats must be 1, not 2, without noise, as in other",
        ),
    ],
)
def test_bad_configurations_say_what_would_be_right(options: dict[str, Any], message: str) -> None:
    with pytest.raises(ComparisonError, match=message):
        configure(replace(POINTS, noiseless=("other",)), **options)


def test_a_comparison_keeps_the_milestones_below_its_horizon() -> None:
    config = configure(STEPS, horizon=100)
    assert config.apply(STEPS).milestones == (99, 100)
