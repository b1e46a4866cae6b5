"""The command `aicon export`."""

from pathlib import Path

import pytest

from aicon_baselines.cli.main import main
from aicon_torch.export.codegen.targets import TARGETS


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


@pytest.mark.parametrize(
    ("task", "option", "name", "message"),
    [
        ("nav2d", "--condition", "fog", "unknown condition 'fog'; valid conditions: range, "),
        ("pusht", "--condition", "fog", "unknown condition 'fog'; valid conditions: determinis"),
        ("nav2d", "--policy", "bug2", "'bug2' cannot be exported; those of the library can"),
    ],
)
def test_what_cannot_be_exported_is_a_sentence(
    task: str, option: str, name: str, message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(["export", task, "-o", "policy.so", option, name])
    assert message in capsys.readouterr().err


def test_its_help_lists_the_machines(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="0"):
        main(["export", "--help"])

    printed = " ".join(capsys.readouterr().out.split())
    for name, target in TARGETS.items():
        assert f"{name} {target.suffix} {target.computers}" in printed


def test_an_unknown_machine_is_a_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(["export", "nav2d", "-o", str(tmp_path / "nav2d.so"), "--target", "pdp11"])
    assert "no target 'pdp11'" in capsys.readouterr().err
