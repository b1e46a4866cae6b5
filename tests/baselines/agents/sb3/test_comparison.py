"""Agents in a comparison, by way of the command lines."""

import re
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("stable_baselines3")
pytest.importorskip("pymunk")

import train_sb3
from aicon_baselines.agents.sb3 import training_config
from aicon_baselines.cli.command_line import run_command
from aicon_baselines.cli.main import main
from aicon_baselines.evaluation.rows_file import read_rows


def compare(folder: Path, *arguments: object) -> list[Any]:
    """Return the rows of a comparison."""
    main(["compare", "--out", str(folder), *map(str, arguments)])
    return read_rows(folder / "episodes.csv")


def test_rows_are_appended_to_the_same_run(
    agent_folders: dict[tuple[str, str], Path], tmp_path: Path
) -> None:
    short = ("--task", "pusht", "--no-compile", "--episodes", 2, "--horizon", 6)
    paths = agent_folders["pusht", "ppo"], agent_folders["pusht", "sac"]

    before = compare(tmp_path, *short, "--policies", "steepest")
    after = compare(tmp_path, *short, "--policies", "sb3", "--sb3-path", *paths)

    assert [row for row in after if row.policy == "steepest"] == before
    agents = {row.policy for row in after} - {"steepest"}
    assert len(agents) == 2
    for name in agents:
        assert re.fullmatch(r"(ppo|sac)_\d+_[0-9a-f]{4}", name)
        assert [row.seed for row in after if row.policy == name] == [row.seed for row in before]


def test_the_comparison_takes_what_the_script_trained(
    tmp_path: Path,
    small: dict[str, int],
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The command that the training prints at its end, with fewer episodes."""
    usual = training_config.TASK_DEFAULTS["nav2d"]
    monkeypatch.setitem(training_config.TASK_DEFAULTS, "nav2d", usual | small)
    arguments = ["--task", "nav2d", "--steps", "128", "--out", str(tmp_path / "agent")]
    run_command(train_sb3.COMMAND, arguments)

    printed = capsys.readouterr().out.split("aicon compare ")[1].split("--out")[0].split()
    rows = compare(tmp_path / "run", *printed, "--no-compile", "--episodes", 2, "--horizon", 5)
    assert len(rows) == 4


def test_a_path_without_sb3_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        compare(tmp_path, "--task", "nav2d", "--policies", "aicon", "--sb3-path", "agent")
    assert "add sb3 to --policies" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("task", "options", "name"),
    [
        ("nav2d", (), "ppo"),
        ("pusht", ("--sampled",), "ppo_sampled"),
        pytest.param("nav2d", ("--sampled",), "ppo_sampled", marks=pytest.mark.slow),
        pytest.param("pusht", (), "ppo", marks=pytest.mark.slow),
    ],
)
def test_without_a_path_it_is_the_agent_that_we_ship(
    task: str, options: tuple[str, ...], name: str, tmp_path: Path
) -> None:
    short = ("--task", task, "--episodes", 1, "--horizon", 2)
    (row,) = compare(tmp_path, *short, "--policies", "sb3", *options)
    assert row.policy == name
