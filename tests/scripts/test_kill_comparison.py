"""Comparisons that are killed and started at once lose nothing."""

from pathlib import Path

import pytest

import kill_comparison
from aicon_baselines.cli.command_line import run_command


@pytest.mark.slow
def test_kills_and_starts_at_once_change_no_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["--kills", "4", "--starts", "5", "--episodes", "16", "--out", str(tmp_path / "runs")]
    run_command(kill_comparison.COMMAND, words)

    printed = capsys.readouterr().out
    assert "4 kills: " in printed and "all files as undisturbed, no row lost" in printed
    assert "5 starts at once: " in printed


def test_a_folder_that_is_there_is_left_alone(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit, match="2"):
        run_command(kill_comparison.COMMAND, ["--out", str(tmp_path)])
    assert "is there already: choose another folder" in capsys.readouterr().err


def test_rows_of_finished_and_unfinished_chunks_are_found(tmp_path: Path) -> None:
    (tmp_path / "unfinished").mkdir()
    (tmp_path / "episodes.csv").write_text("policy,seed\na,1\na,2")
    (tmp_path / "unfinished" / "0.csv").write_text("a,3\na,")
    assert kill_comparison.rows_in(tmp_path) == {"a,1", "a,3"}
