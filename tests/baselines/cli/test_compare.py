"""The command `aicon compare`, as users start it."""

import argparse
import os
import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

from aicon_baselines import tasks
from aicon_baselines.agents import compiled, factory
from aicon_baselines.cli.compare import add_arguments, choose_policies
from aicon_baselines.evaluation.rows_file import read_rows

TASKS = [
    "nav2d",
    pytest.param(
        "pusht", marks=pytest.mark.skipif(find_spec("pymunk") is None, reason="needs pymunk")
    ),
]


def aicon_compare(*words: str, task: str = "nav2d") -> subprocess.CompletedProcess[str]:
    """Run it in a process of its own."""
    command = [sys.executable, "-m", "aicon_baselines.cli.main", "compare", "--task", task, *words]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.mark.parametrize("task", TASKS)
def test_it_saves_and_prints_the_results(tmp_path: Path, task: str) -> None:
    words = ["--policies", "aicon", "steepest", "--episodes", "2", "--horizon", "10"]
    result = aicon_compare(*words, "--out", str(tmp_path), task=task)
    assert result.returncode == 0, result.stderr

    condition = tasks.load(task).conditions[0]
    assert f"| {condition} | aicon | 0/2 = 0.0% (0.0% to 65.8%) |" in result.stdout
    assert ", aicon: failed with seed 0 (" in result.stdout
    files = {path.name for path in tmp_path.iterdir()}
    saved = {"config.json", "episodes.csv", "success_curve.png", "summary.json"}
    assert files == {".lock", *saved}


def test_it_says_what_is_wrong(tmp_path: Path) -> None:
    result = aicon_compare("--policies", "oracle", "--out", str(tmp_path / "new"))
    assert result.returncode == 2
    message = "unknown policy 'oracle' for task 'nav2d'; valid policies: aicon, "
    assert message in result.stderr
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize("backend", ["loky", "dask"])
def test_it_gives_the_same_rows_on_every_backend(backend: str, tmp_path: Path) -> None:
    """The real task, with workers that import everything themselves."""
    if backend == "dask":
        pytest.importorskip("distributed")
    words = ["--policies", "aicon", "--episodes", "2", "--seed", "1024", "--horizon", "30"]
    one, other = tmp_path / "one", tmp_path / "other"

    for folder, ways in ((one, ["--jobs", "1"]), (other, ["--jobs", "2", "--backend", backend])):
        result = aicon_compare(*words, *ways, "--out", str(folder))
        assert result.returncode == 0, result.stderr
    assert (one / "episodes.csv").read_bytes() == (other / "episodes.csv").read_bytes()


def test_a_policy_can_be_compared_compiled(tmp_path: Path) -> None:
    """The robot must not notice; in a millionth of a metre after ten steps neither does the row."""
    if not shutil.which(os.environ.get("CXX", "g++")):
        pytest.skip("there is no C++ compiler")
    words = ["--policies", "aicon", "--episodes", "1", "--horizon", "10", "--out", str(tmp_path)]

    for options in ([], ["--compile"]):
        result = aicon_compare(*words, *options)
        assert result.returncode == 0, result.stderr

    rows = sorted(read_rows(tmp_path / "episodes.csv"), key=lambda row: row.policy)
    uncompiled, after_compiling = rows
    assert (uncompiled.policy, after_compiling.policy) == ("aicon", "aicon_compiled")
    assert after_compiling.distance == pytest.approx(uncompiled.distance, abs=1e-6)


def test_policies_of_the_arm_are_always_compiled() -> None:
    pytest.importorskip("aicon_envs.panda_push")
    parser = argparse.ArgumentParser()
    add_arguments(parser)
    words = ["--task", "panda_push", "--policies", "steepest", "--out", "runs"]

    policies = choose_policies(tasks.load("panda_push"), parser.parse_args(words))
    assert policies == {"steepest": compiled(factory("panda_push", "steepest"))}
