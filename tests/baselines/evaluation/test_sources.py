"""Rows of one's own task or policy remember which file made them."""

import hashlib
import json
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from _inputs.comparison import POINTS, WALKERS

from aicon_baselines.evaluation.comparison import compare
from aicon_baselines.evaluation.config import configure
from aicon_baselines.evaluation.run_folder import RunFolder
from aicon_baselines.tasks import load

WARNING = "rows were made by another wheelie.py; give a new --out"
OWN = "from dataclasses import replace\nfrom aicon_baselines.tasks.nav2d import TASK\n"


@pytest.fixture
def wheelie(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A module of one's own, in the folder where one is."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    monkeypatch.delitem(sys.modules, "wheelie", raising=False)
    file = tmp_path / "wheelie.py"
    file.write_text(OWN)
    load("wheelie:TASK")
    return file


def run(path: Path, task: str, policy: str) -> bytes:
    own = replace(POINTS, name=task)
    with RunFolder.open(path, configure(own, episodes=2)) as folder:
        compare(own, {policy: WALKERS["fast"]}, folder)
    return (path / "episodes.csv").read_bytes()


@pytest.mark.parametrize(("task", "policy"), [("wheelie:TASK", "fast"), ("points", "wheelie:fast")])
def test_rows_of_another_file_are_kept_with_a_warning(
    task: str, policy: str, wheelie: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    rows = run(tmp_path / "out", task, policy)
    digest = hashlib.sha256(wheelie.read_bytes()).hexdigest()
    assert json.loads((tmp_path / "out" / "sources.json").read_text()) == {"wheelie": digest}
    assert run(tmp_path / "out", task, policy) == rows and WARNING not in caplog.text

    wheelie.write_text(OWN + "SPEED = 2\n")
    assert run(tmp_path / "out", task, policy) == rows
    assert WARNING in caplog.text

    caplog.clear()
    run(tmp_path / "new", task, policy)
    assert WARNING not in caplog.text


def test_what_is_shipped_needs_no_note(tmp_path: Path) -> None:
    run(tmp_path / "out", "points", "fast")
    assert not (tmp_path / "out" / "sources.json").exists()
