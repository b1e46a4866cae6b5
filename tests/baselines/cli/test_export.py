"""The command `aicon export`."""

from pathlib import Path

import pytest

from aicon_baselines.cli.main import main


def test_it_writes_a_source_that_names_its_task(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "nav2d.c"
    main(["export", "nav2d", "-o", str(path)])

    assert "aicon_step" in path.read_text()
    assert str(path) in capsys.readouterr().out


def test_a_name_that_ends_otherwise_is_a_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(["export", "nav2d", "-o", str(tmp_path / "nav2d.pt2")])
    assert "ends in .so" in capsys.readouterr().err
