"""The command `aicon compare`, as users start it."""

import subprocess
import sys
from pathlib import Path

import pytest
from _inputs.needs import NEEDS_PYMUNK

from aicon_baselines import tasks
from aicon_baselines.cli.main import main
from aicon_baselines.evaluation.rows_file import read_rows
from aicon_torch.export.codegen import has_compiler


def aicon_compare(*words: str, task: str = "nav2d") -> subprocess.CompletedProcess[str]:
    """Run it in a process of its own."""
    command = [sys.executable, "-m", "aicon_baselines.cli.main", "compare", "--task", task, *words]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)


SHORT = ["--policies", "aicon", "steepest", "--episodes", "2", "--horizon", "2", "--no-compile"]


@pytest.mark.parametrize(
    "task", ["nav2d", pytest.param("pusht", marks=[NEEDS_PYMUNK, pytest.mark.slow])]
)
def test_it_saves_and_prints_the_results(
    tmp_path: Path, task: str, capsys: pytest.CaptureFixture[str]
) -> None:
    main(["compare", "--task", task, *SHORT, "--out", str(tmp_path)])
    printed = capsys.readouterr().out

    condition = tasks.load(task).conditions[0]
    assert f"| {condition} | aicon | 0/2 = 0.0% (0.0% to 65.8%) |" in printed
    assert ", aicon: failed with seed 0 (" in printed
    files = {path.name for path in tmp_path.iterdir()}
    saved = {"config.json", "episodes.csv", "success_curve.png", "summary.json", "versions.json"}
    assert files == {".lock", *saved}


@pytest.mark.slow
def test_it_runs_in_a_process_of_its_own(tmp_path: Path) -> None:
    words = ["--policies", "steepest", "--episodes", "1", "--horizon", "2", "--no-compile"]
    result = aicon_compare(*words, "--jobs", "1", "--out", str(tmp_path))
    assert result.returncode == 0, result.stderr
    assert "| steepest | 0/1 = 0.0% (0.0% to 79.3%) |" in result.stdout


def test_it_says_what_is_wrong(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    wrong = ["--policies", "oracle", "--out", str(tmp_path / "new")]
    with pytest.raises(SystemExit) as stopped:
        main(["compare", "--task", "nav2d", *wrong])
    assert stopped.value.code == 2
    message = "unknown policy 'oracle' for task 'nav2d'; valid policies: aicon, "
    assert message in capsys.readouterr().err
    assert not (tmp_path / "new").exists()


BRIEF = ["--policies", "steepest", "--seed", "1024", "--episodes", "2", "--horizon", "30"]


@pytest.fixture(scope="module")
def alone(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """The rows of a comparison without workers."""
    folder = tmp_path_factory.mktemp("alone")
    main(
        ["compare", "--task", "nav2d", *BRIEF, "--no-compile", "--jobs", "1", "--out", str(folder)]
    )
    return (folder / "episodes.csv").read_bytes()


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["loky", "dask"])
def test_it_gives_the_same_rows_on_every_backend(
    backend: str, alone: bytes, tmp_path: Path
) -> None:
    """The real task, with workers that import everything themselves."""
    if backend == "dask":
        pytest.importorskip("distributed")
    ways = ["--no-compile", "--jobs", "2", "--backend", backend]
    result = aicon_compare(*BRIEF, *ways, "--out", str(tmp_path))
    assert result.returncode == 0, result.stderr
    assert (tmp_path / "episodes.csv").read_bytes() == alone


def test_compiled_or_not_the_rows_are_the_same(tmp_path: Path) -> None:
    if not has_compiler():
        pytest.skip("there is no C compiler")
    words = ["compare", "--task", "nav2d", "--policies", "aicon", "--episodes", "1"]
    compiled, readable = tmp_path / "compiled", tmp_path / "readable"
    main([*words, "--horizon", "5", "--out", str(compiled)])
    main([*words, "--horizon", "5", "--out", str(readable), "--no-compile"])

    assert read_rows(compiled / "episodes.csv") == read_rows(readable / "episodes.csv")
