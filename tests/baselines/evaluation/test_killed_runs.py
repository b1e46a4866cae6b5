"""Comparisons that are killed, or started twice, lose no row and change no file."""

import random
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

POLICY = '''
import numpy as np

class TowardTarget:
    """Heads for the target, slowly."""

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        bearing = observation["bearing"]
        return 0.1 * np.concatenate((np.cos(bearing), np.sin(bearing)), -1), None

def slow(condition):
    return TowardTarget()
'''
FILES = ("episodes.csv", "summary.json", "config.json")


@pytest.fixture(scope="module")
def here(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where comparisons run, among them one that nobody disturbed."""
    folder = tmp_path_factory.mktemp("runs")
    (folder / "policies_here.py").write_text(POLICY)
    finish(start(folder, "undisturbed"))
    return folder


def start(here: Path, out: str) -> "subprocess.Popen[str]":
    """Start a comparison in a process of its own."""
    words = ["--task", "nav2d", "--policies", "policies_here:slow", "--jobs", "2"]
    words += ["--episodes", "8", "--horizon", "1000", "--seed", "60000", "--out", out]
    command = [sys.executable, "-m", "aicon_baselines.cli.main", "compare", *words]
    pipe = subprocess.PIPE
    return subprocess.Popen(command, cwd=here, text=True, stdout=subprocess.DEVNULL, stderr=pipe)


def finish(process: "subprocess.Popen[str]") -> None:
    """Wait for a comparison that has to end well."""
    _, errors = process.communicate()
    assert process.returncode == 0, errors


def rows_in(folder: Path) -> set[str]:
    """The whole lines of a folder: of the finished file, and of unfinished chunks."""
    lines: set[str] = set()
    for path in (folder / "episodes.csv", *folder.glob("unfinished/*.csv")):
        if path.exists():
            lines.update(path.read_text().split("\n")[:-1])
    return lines


def check_same(folder: Path, undisturbed: Path) -> None:
    for name in FILES:
        assert (folder / name).read_bytes() == (undisturbed / name).read_bytes(), name


def test_runs_that_are_killed_lose_no_row_and_end_with_the_same_files(here: Path) -> None:
    generator, kept = random.Random(0), set[str]()

    for _ in range(2):
        process = start(here, "killed")
        try:
            process.wait(generator.uniform(2.0, 8.0))
        except subprocess.TimeoutExpired:
            process.kill()
        process.communicate()
        now = rows_in(here / "killed")
        assert kept <= now
        kept = now

    finish(start(here, "killed"))
    check_same(here / "killed", here / "undisturbed")


def test_of_runs_that_start_at_once_in_one_folder_one_works_and_the_others_say_so(
    here: Path,
) -> None:
    processes = [start(here, "at_once") for _ in range(2)]
    for process in processes:
        _, errors = process.communicate()
        assert process.returncode == 0 or "another process" in errors, errors
    check_same(here / "at_once", here / "undisturbed")
