"""Rows remember which version made them, and those of one's own task or policy which file."""

import hashlib
import json
import sys
from dataclasses import replace
from pathlib import Path

import pytest
import torch
from _inputs.comparison import POINTS, WALKERS, compare_walkers

import aicon_torch
from aicon_baselines.agents.registry import compiled, factory
from aicon_baselines.evaluation.comparison import compare
from aicon_baselines.evaluation.config import configure
from aicon_baselines.evaluation.run_folder import RunFolder
from aicon_baselines.evaluation.sources import note_versions
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


def versions(folder: Path) -> dict[str, list[dict[str, str | bool | None]]]:
    found: dict[str, list[dict[str, str | bool | None]]]
    found = json.loads((folder / "versions.json").read_text())
    return found


def test_rows_of_another_version_are_kept_with_a_warning(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    rows = compare_walkers(tmp_path)
    now = {"aicon-torch": aicon_torch.__version__, "torch": torch.__version__, "compiled": None}
    assert versions(tmp_path) == {"slow": [now], "fast": [now]}

    # A row is missing: another version makes it anew, and nothing if none is.
    monkeypatch.setattr(aicon_torch, "__version__", "0.0.9")
    for _ in range(2):
        (tmp_path / "episodes.csv").write_bytes(rows[: rows.rindex(b"slow")])
        assert compare_walkers(tmp_path) == compare_walkers(tmp_path) == rows
        assert versions(tmp_path) == {"slow": [now, now | {"aicon-torch": "0.0.9"}], "fast": [now]}
        assert "rows of slow were made by another version" in caplog.text
        assert len(caplog.records) == 1
        caplog.clear()


def test_versions_that_nobody_noted_are_another(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    note_versions(tmp_path, {"slow": WALKERS["slow"]}, ["slow"])
    assert versions(tmp_path)["slow"][0] is None
    assert "rows of slow were made by another version" in caplog.text


def test_it_is_noted_whether_a_policy_is_compiled(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    readable = factory("nav2d", "aicon")
    for build in (readable, compiled(readable)):
        note_versions(tmp_path, {"aicon": build}, [])
        assert versions(tmp_path)["aicon"][0]["compiled"] == (build is not readable)
    assert not caplog.records

    note_versions(tmp_path, {"aicon": readable}, ["aicon"])
    assert "or compiled otherwise (versions.json)" in caplog.text
