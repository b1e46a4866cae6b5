"""An episode of a comparison is run again with the settings of the run, and drawn."""

from pathlib import Path

import pytest
from _inputs.comparison import rows_by_steps

from aicon_baselines.cli.main import main
from aicon_baselines.diagnosis.rerun import choose_row, rerun
from aicon_baselines.evaluation.config import configure
from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.evaluation.row import Row
from aicon_baselines.evaluation.run_folder import RunFolder
from aicon_baselines.tasks import load

HORIZON = 60


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A comparison in navigation whose episode was too short to arrive."""
    config = configure(load("nav2d"), seed=1025, horizon=HORIZON, episodes=1)
    row = Row("aicon", "range", 0, 1025, "u_trap_05", False, None, False, 1.0, 4.0, 3.0)
    with RunFolder.open(tmp_path, config) as run:
        run.append([row])
    return tmp_path


def test_the_command_says_what_is_seen_and_draws_it(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    main(["diagnose", str(folder), "--seed", "1025"])

    printed = capsys.readouterr().out
    assert f"no success after {HORIZON} steps" in printed
    assert "reach" in printed
    turns = printed.partition("What led, turn by turn:")[2]
    assert turns.startswith("\n0.0 to ") and "reach → p_tar → x_rob → a" in turns
    assert (folder / "diagnosis_1025.png").stat().st_size > 10_000


def test_it_tells_what_lies_around_the_robot(folder: Path) -> None:
    again = rerun(folder, 1025)
    assert {"target", "wall.0"} <= again.around.keys()
    assert not again.flipped


def test_a_seed_that_was_not_run_is_an_error_that_names_those_that_were(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        main(["diagnose", str(folder), "--seed", "3"])
    assert "seeds: 1025 to 1025" in capsys.readouterr().err


def test_a_folder_without_a_comparison_is_an_error(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        main(["diagnose", str(tmp_path), "--seed", "3"])
    assert "is no folder of a comparison" in capsys.readouterr().err


def test_an_episode_of_one_step_is_an_error(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("aicon_baselines.diagnosis.rerun.compiled", lambda build: build)
    config = configure(load("nav2d"), seed=1025, horizon=1, episodes=1)
    row = Row("aicon", "range", 0, 1025, "u_trap_05", False, None, False, 1.0, 4.0, 3.0)
    with RunFolder.open(tmp_path, config) as run:
        run.append([row])

    with pytest.raises(SystemExit):
        main(["diagnose", str(tmp_path), "--seed", "1025"])
    assert "seed 1025 ended with its first step" in capsys.readouterr().err


def test_the_policy_that_failed_is_looked_at_unless_another_is_named() -> None:
    rows = [*rows_by_steps("good", [10]), *rows_by_steps("bad", [None])]
    assert choose_row(rows, seed=rows[0].seed).policy == "bad"
    assert choose_row(rows, seed=rows[0].seed, policy="good").policy == "good"
    with pytest.raises(ComparisonError, match="policies: bad, good"):
        choose_row(rows, seed=rows[0].seed, policy="none")
