"""The command `aicon` as a whole: choosing a command, listing, and errors as sentences."""

import argparse
import os
import subprocess
import sys
from pathlib import Path
from typing import IO

import pytest

from aicon_baselines import agents, extras
from aicon_baselines.cli.command_line import Command, add_option, at_least, run_command
from aicon_baselines.cli.main import main
from aicon_baselines.evaluation import ComparisonError
from aicon_torch import OptionError


def test_list_names_tasks_policies_conditions_environments_and_extras(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "2000")
    main(["list"])
    printed = capsys.readouterr().out
    assert "task nav2d\n  presets     aicon, paper_literal, steepest, potential_field\n" in printed
    assert f"ablations   {', '.join(agents.ablations('nav2d'))}\n" in printed
    assert "conditions  {panda,ur5,xarm7}_{pose,position}_{home,random}{,_fast,_ball" in printed
    assert "opponents   pcgrad, upgrad, cagrad, bug2, wall_follower\n" in printed
    assert "conditions  range, range_bearing, " in printed
    assert "aicon/Nav2D-v0, aicon/PushT-v0, aicon/ArmPush-v0" in printed
    assert "compare     installed\n" in printed


def test_list_says_how_to_install_what_is_missing(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(extras.EXTRAS, "cluster", ("no_such_module",))
    main(["list"])
    expected = "cluster     not installed: pip install 'aicon-torch[cluster]'"
    assert expected in capsys.readouterr().out


@pytest.mark.parametrize("words", [[], ["fly"]])
def test_an_unknown_command_is_refused_with_the_list(
    words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(words)
    assert "{list,run,watch,compare,diagnose,figures,bench,export}" in capsys.readouterr().err


def add_nothing(parser: argparse.ArgumentParser) -> None:
    """Declare no arguments."""


def run_with(error: BaseException) -> Command:
    """A command that ends with an error."""

    def run(arguments: argparse.Namespace) -> None:
        raise error

    return Command("What it does.", add_nothing, run, when_stopped="stopped; go on later")


@pytest.mark.parametrize(
    ("error", "status", "sentence"),
    [
        (ComparisonError("no such task"), 2, "error: no such task"),
        (OptionError("no such option"), 2, "error: no such option"),
        (
            ModuleNotFoundError("No module named 'joblib'", name="joblib.parallel"),
            2,
            "error: No module named 'joblib'; this needs: pip install 'aicon-torch[compare]'",
        ),
        (KeyboardInterrupt(), 130, "stopped; go on later"),
    ],
    ids=["comparison", "option", "extra", "stopped"],
)
def test_what_a_user_can_mend_is_a_sentence(
    error: BaseException, status: int, sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ending:
        run_command(run_with(error), [], "aicon test")
    assert ending.value.code == status
    assert sentence in capsys.readouterr().err


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="the system has no full device")
@pytest.mark.parametrize(
    "buffered",
    [pytest.param("", id="buffered"), pytest.param("1", id="unbuffered", marks=pytest.mark.slow)],
)
def test_output_that_cannot_be_written_is_a_sentence_or_nothing(buffered: str) -> None:
    command = [sys.executable, "-m", "aicon_baselines.cli.main", "list"]
    environment = {**os.environ, "PYTHONUNBUFFERED": buffered}

    def run_into(output: IO[str]) -> tuple[int, str]:
        ended = subprocess.run(
            command, stdout=output, stderr=subprocess.PIPE, text=True, env=environment, check=False
        )
        return ended.returncode, ended.stderr

    # Nobody reads it.
    reads, writes = os.pipe()
    os.close(reads)
    with os.fdopen(writes, "w") as closed:
        assert run_into(closed) == (141, "")

    # There is no room for it.
    with Path("/dev/full").open("w") as full:
        status, told = run_into(full)
    assert status == 2
    assert told.endswith("error: No space left on device\n")


@pytest.mark.parametrize(
    "error",
    [ValueError("a bug"), ModuleNotFoundError("a bug", name="aicon_torch.missing")],
    ids=["value", "module"],
)
def test_what_is_a_bug_stays_a_traceback(error: Exception) -> None:
    with pytest.raises(type(error), match="a bug"):
        run_command(run_with(error), [])


@pytest.mark.parametrize(("text", "told"), [("0", "1 or more, not 0"), ("few", "'few'")])
def test_a_number_has_a_least_value(
    text: str, told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    parser = argparse.ArgumentParser()
    add_option(parser, "--rounds", 3, "turns", type=at_least(1))
    assert parser.parse_args([]).rounds == 3
    with pytest.raises(SystemExit):
        parser.parse_args(["--rounds", text])
    assert told in capsys.readouterr().err


def test_commands_use_one_thread() -> None:
    program = "import aicon_baselines.cli.main, torch; print(torch.get_num_threads())"
    untold = {name: value for name, value in os.environ.items() if name != "OMP_NUM_THREADS"}
    assert run_program(program, untold) == "1"


def test_commands_leave_the_number_of_threads_to_whoever_sets_it() -> None:
    program = "import aicon_baselines.cli.main, os; print(os.environ['OMP_NUM_THREADS'])"
    assert run_program(program, {**os.environ, "OMP_NUM_THREADS": "2"}) == "2"


def run_program(program: str, environment: dict[str, str]) -> str:
    """What a program prints in a process of its own."""
    command = [sys.executable, "-c", program]
    result = subprocess.run(
        command, env=environment, capture_output=True, text=True, check=True, timeout=300
    )
    return result.stdout.strip()
