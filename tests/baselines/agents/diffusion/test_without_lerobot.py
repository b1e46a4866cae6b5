"""What the command lines and the hub say before LeRobot is needed, or where it is missing."""

import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest

pytest.importorskip("pymunk")

import collect_demos
import train_diffusion
from aicon_baselines.agents.diffusion import hub
from aicon_baselines.agents.registry import factory
from aicon_baselines.cli.command_line import run_command
from aicon_baselines.cli.main import main


def compare(arguments: list[str]) -> None:
    main(["compare", *arguments])


collect = partial(run_command, collect_demos.COMMAND)
train = partial(run_command, train_diffusion.COMMAND)

DIFFUSION = "--task pusht --policies diffusion --out run --diffusion-path"


@pytest.fixture
def no_lerobot(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in [name for name in sys.modules if name.split(".")[0] == "lerobot"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "lerobot", None)


@pytest.mark.usefixtures("no_lerobot")
@pytest.mark.parametrize(
    ("command", "arguments"),
    [
        (collect, "--out demos"),
        (train, "--data demos --out policy"),
        (compare, f"{DIFFUSION} ."),
        (compare, f"{DIFFUSION} a/b@{'0' * 40}"),
    ],
    ids=["collect", "train", "compare a folder", "compare a repository"],
)
def test_without_lerobot_an_error_says_how_to_get_it(
    command: Callable[[list[str]], None],
    arguments: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit, match="2"):
        command(arguments.split())
    assert "pip install 'aicon-torch[lerobot]'" in capsys.readouterr().err
    assert callable(factory("pusht", "aicon"))  # the others do not need it


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            "--task nav2d --policies diffusion",
            "no policy 'diffusion' was trained for nav2d, only for pusht",
        ),
        (
            "--task pusht --policies aicon --diffusion-path x",
            "add diffusion to --policies",
        ),
        (
            "--task nav2d --policies diffusion --diffusion-path x",
            "has no lesson that says what a student learns; tasks that have one: pusht",
        ),
        (
            "--task pusht --policies diffusion --diffusion-path x",
            "there is no folder x",
        ),
    ],
)
def test_a_comparison_that_makes_no_sense_is_an_error(
    arguments: str, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit, match="2"):
        compare([*arguments.split(), "--out", str(tmp_path / "run")])
    assert message in capsys.readouterr().err
    assert not (tmp_path / "run").exists()


def test_a_hub_that_does_not_answer_is_noticed_at_once() -> None:
    start = time.monotonic()
    assert "http://127.0.0.1:9 does not answer" in hub._why_unreachable("http://127.0.0.1:9")
    assert time.monotonic() - start < 5.0
