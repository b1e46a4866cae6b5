"""The command `aicon watch`."""

import os
import signal
import subprocess
import sys
from urllib.request import urlopen

import pytest

pytest.importorskip("viser", reason="the live view needs the extra [view]")

from aicon_baselines.cli.main import main
from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.tasks import names
from aicon_baselines.view.episode import LiveEpisode


def obey_interrupts() -> None:
    """In a job in the background the shell has switched Ctrl-C off."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


@pytest.mark.slow
def test_it_serves_a_page_without_a_display_and_ends_with_a_sentence() -> None:
    words = ["watch", "nav2d", "--port", "0"]
    shell = {key: value for key, value in os.environ.items() if key != "DISPLAY"}
    program = [sys.executable, "-m", "aicon_baselines.cli.main", *words]
    with subprocess.Popen(
        program,
        env=shell,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=obey_interrupts,
    ) as process:
        try:
            assert process.stdout is not None
            line = process.stdout.readline()
            assert line.startswith("watch it at http://localhost:")
            assert line.endswith("(Ctrl-C ends it)\n")

            address = line.split()[3].replace("localhost", "127.0.0.1")
            assert b"<html" in urlopen(address, timeout=60).read()[:1000].lower()

            # What is told while it is built comes after the address.
            assert process.stderr is not None
            said = [process.stderr.readline()]
            while said[-1] and "Building the policy" not in said[-1]:
                said.append(process.stderr.readline())
            process.send_signal(signal.SIGINT)
            printed, errors = process.communicate(timeout=60)
        finally:
            process.kill()  # whatever was wrong with it, nobody waits for it
    assert (process.returncode, printed) == (130, "")
    assert "Building the policy" in said[-1] and errors.endswith("\nstopped\n")


def test_its_address_is_said_before_anything_is_built(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(episode: LiveEpisode, seed: int) -> None:
        raise ComparisonError("nothing is built today")

    monkeypatch.setattr(LiveEpisode, "start", refuse)
    with pytest.raises(SystemExit, match="2"):
        main(["watch", "nav2d", "--port", "0"])
    said = capsys.readouterr()
    assert said.out.startswith("watch it at http://localhost:")
    assert "nothing is built today" in said.err


def test_a_wrong_name_is_refused_before_an_address_is_said(
    capsys: pytest.CaptureFixture[str],
) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(["watch", "nav2d", "--condition", "fog"])
    assert capsys.readouterr().out == ""


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["fly"], "unknown task 'fly'; valid tasks: nav2d, pusht"),
        (["nav2d", "--port", "70000"], "--port must be between 0 and 65535, not 70000"),
        (["nav2d", "--host", "no host"], "cannot listen at 'no host'"),
        (["nav2d", "--policy", "bug2"], "has no gradients to show"),
        (["nav2d", "--policy", "oracle"], "unknown policy 'oracle'"),
        (["nav2d", "--record", "episode.avi"], "a recording ends in .html, not '.avi'"),
    ],
)
def test_it_says_what_is_wrong(
    words: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(["watch", *words])
    assert message in capsys.readouterr().err


def test_its_help_names_every_task(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="0"):
        main(["watch", "--help"])
    said = capsys.readouterr().out
    assert all(task in said for task in names())
