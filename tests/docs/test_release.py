"""A release has one number and one date, wherever it is named."""

import re

import pytest
from _documents import ROOT

from aicon_baselines.cli.main import main
from aicon_torch import __version__


def test_the_citation_and_the_changelog_have_the_version_and_its_date() -> None:
    cited = (ROOT / "CITATION.cff").read_text()
    (number,) = re.findall(r"^version: (.*)$", cited, re.MULTILINE)
    (day,) = re.findall(r"^date-released: (.*)$", cited, re.MULTILINE)
    released = re.findall(r"^## \[(\d.*)\] - (.*)$", (ROOT / "CHANGELOG.md").read_text(), re.M)
    assert (number, day) == released[0]
    assert number == __version__


def test_the_command_says_its_version(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="0"):
        main(["--version"])
    assert capsys.readouterr().out == f"{__version__}\n"
