"""Tutorials, and the page to start with, run from top to bottom and print what they say."""

import contextlib
import importlib.util
import io
import os
import re
import sys
import types
from pathlib import Path

import pytest
from _documents import ROOT

from aicon_baselines.cli.main import main
from notebooks import NOTEBOOKS, PAGES, run_notebook, to_notebook

NEEDED = {
    "own_arm": ("pytorch_kinematics", "trimesh", "matplotlib"),
    "own_object": ("pymunk", "matplotlib"),
    "pick": ("mujoco",),
    "shield": ("matplotlib",),
    "network": ("matplotlib",),
    "learning": ("pymunk",),
    "logs": ("pymunk", "lerobot"),
    "wheels": ("matplotlib",),
    "task": (),
    "world": ("gymnasium_robotics", "matplotlib"),
}
NUMBER = re.compile(r"[+-]?\d+(?:\.\d+)?(?:e[+-]?\d+)?")
BLOCK = re.compile(r"^```(python|text)\n(.*?)^```", re.MULTILINE | re.DOTALL)

os.environ.setdefault("MPLBACKEND", "agg")


def test_each_tutorial_is_on_the_site_and_runs_one_way_or_the_other() -> None:
    names = {page.stem for page in PAGES}
    assert names == {*NOTEBOOKS, *NEEDED}

    contents = (ROOT / "docs" / "index.md").read_text()
    for name in names:
        assert f"tutorials/{name}\n" in contents


@pytest.mark.slow
@pytest.mark.parametrize("name", NEEDED)
def test_the_program_of_a_tutorial_runs_and_prints_what_it_says(name: str) -> None:
    for module in NEEDED[name]:
        pytest.importorskip(module)

    page = ROOT / "docs" / "tutorials" / f"{name}.md"
    check_what_is_printed(page, run_page(page))


def test_the_task_of_a_tutorial_is_compared_by_its_module(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    page = ROOT / "docs" / "tutorials" / "task.md"
    blocks = [code for language, code in BLOCK.findall(page.read_text()) if language == "python"]
    (tmp_path / "dock.py").write_text("\n".join(blocks[:-1]))
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))

    policies = ["--policies", "aicon", "not_told_of_wind", "--conditions", "windy", "--no-compile"]
    episodes = ["--episodes", "2", "--horizon", "3", "--out", "out"]
    main(["compare", "--task", "dock:TASK", *policies, *episodes])
    main(["run", "--task", "dock:TASK", "--horizon", "3", "--no-compile"])

    printed = capsys.readouterr().out
    assert "not_told_of_wind" in printed and "no success after 0.3 s" in printed
    rows = (tmp_path / "out" / "episodes.csv").read_text().splitlines()
    assert len(rows) == 1 + 2 * 2


@pytest.mark.slow
def test_the_world_of_a_tutorial_is_compared_and_diagnosed_as_it_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("gymnasium_robotics")
    page = ROOT / "docs" / "tutorials" / "world.md"
    blocks = [code for language, code in BLOCK.findall(page.read_text()) if language == "python"]
    (tmp_path / "rooms.py").write_text("\n".join(blocks[1:4]))
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))

    policies = ["--policies", "aicon", "without_exploration", "--conditions", "door"]
    episodes = ["--episodes", "1", "--seed", "405000", "--jobs", "1", "--out", "out"]
    main(["compare", "--task", "rooms:TASK", *policies, *episodes])
    main(["diagnose", "out", "--policy", "without_exploration", "--seed", "405000"])

    printed = capsys.readouterr().out
    assert "| door | aicon | 1/1" in printed and "| door | without_exploration | 0/1" in printed
    assert "nothing is explored" in printed


def test_what_stands_on_the_first_page_runs_in_its_order_and_prints_what_it_says() -> None:
    pytest.importorskip("pymunk")
    page = ROOT / "docs" / "start.md"
    check_what_is_printed(page, run_page(page))


def run_page(page: Path) -> str:
    """Run the blocks of a page one after the other, as a module, and return what they print."""
    module = types.ModuleType(f"page_{page.stem}")
    sys.modules[module.__name__] = module
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        for language, code in BLOCK.findall(page.read_text()):
            if language == "python":
                exec(compile(code, str(page), "exec"), module.__dict__)
    return printed.getvalue()


@pytest.mark.slow
@pytest.mark.parametrize("name", NOTEBOOKS)
def test_a_notebook_runs_and_prints_what_its_page_says(name: str, tmp_path: Path) -> None:
    for module in ("jupytext", "nbclient", "ipykernel", "matplotlib"):
        if importlib.util.find_spec(module) is None:
            pytest.skip(f"{module} is not installed")

    page = ROOT / "docs" / "tutorials" / f"{name}.md"
    printed = run_notebook(to_notebook(page), tmp_path)

    check_what_is_printed(page, "".join(printed))


def check_what_is_printed(page: Path, printed: str) -> None:
    """Every line that a page shows as output is printed, up to the last digits of its numbers."""
    for language, text in BLOCK.findall(page.read_text()):
        if language == "text":
            for line in text.splitlines():
                assert any(is_the_same(line, other) for other in printed.splitlines()), line


def is_the_same(line: str, printed: str) -> bool:
    """Whether two lines differ in no more than the last digits of their numbers."""
    if NUMBER.sub("#", line.strip()) != NUMBER.sub("#", printed.strip()):
        return False

    pairs = zip(NUMBER.findall(line), NUMBER.findall(printed), strict=True)
    return all(is_as_large(shown, found) for shown, found in pairs)


def is_as_large(shown: str, found: str) -> bool:
    """Whether a number is as large as a page shows it: to a tenth, or its last digit."""
    decimals = len(shown.partition(".")[2])
    tolerance = max(0.1 * abs(float(shown)), 1.01 * 0.1**decimals)
    return abs(float(shown) - float(found)) <= tolerance
