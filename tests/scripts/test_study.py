"""The script that compares variants."""

from pathlib import Path

import pytest

import study
from aicon_baselines.cli.command_line import run_command

SHORT = ["--task", "nav2d", "--episodes", "2", "--horizon", "2", "--no-compile"]


def test_it_saves_and_prints_the_results(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "new"
    words = ["--variants", "resolution.temperature=1.0", "--out", str(out)]
    run_command(study.COMMAND, [*SHORT, *words])

    assert "| resolution.temperature=1.0 | 0.0% (0.0% to 65.8%) |" in capsys.readouterr().out
    files = {path.name for path in out.iterdir()}
    assert files == {
        ".lock",
        "config.json",
        "episodes.csv",
        "study.json",
        "study.png",
        "versions.json",
    }


def test_it_says_what_is_wrong(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        run_command(study.COMMAND, [*SHORT, "--variants", "law.no_such=1", "--out", str(tmp_path)])
    assert "variant 'law.no_such=1'" in capsys.readouterr().err
