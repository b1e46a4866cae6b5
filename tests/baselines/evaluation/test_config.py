"""What a comparison is made for, and the files of its folder."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from _inputs.comparison import POINTS, STEPS, handmade_rows

from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.evaluation.config import configure
from aicon_baselines.evaluation.row import Row


def test_another_configuration_is_refused(tmp_path: Path) -> None:
    config = configure(POINTS, episodes=4)
    config.save(tmp_path / "config.json")
    config.save(tmp_path / "config.json")

    message = "another comparison: episodes is 4 there and 5 here; seed is 0 there and 1"
    with pytest.raises(ComparisonError, match=message):
        replace(config, episodes=5, seed=1).save(tmp_path / "config.json")


@pytest.mark.parametrize(
    ("text", "reason"), [("", "holds no JSON"), ("{", "holds no JSON"), ("[]", "holds a list")]
)
def test_a_broken_configuration_says_what_to_do(tmp_path: Path, text: str, reason: str) -> None:
    path = tmp_path / "config.json"
    path.write_text(text)
    with pytest.raises(ComparisonError, match=rf"config.json {reason}.*delete that file"):
        configure(POINTS).save(path)


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
        (
            {"conditions": ["other+third"], "repeats": 2},
            "repeats must be 1, not 2, without noise, as in other\\+third",
        ),
    ],
)
def test_bad_configurations_say_what_would_be_right(options: dict[str, Any], message: str) -> None:
    task = replace(POINTS, noiseless=("other", "third"), faults=("other", "third"))
    with pytest.raises(ComparisonError, match=message):
        configure(task, **options)


def test_a_comparison_keeps_the_milestones_below_its_horizon() -> None:
    config = configure(STEPS, horizon=100)
    assert config.apply(STEPS).milestones == (99, 100)
