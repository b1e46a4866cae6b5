"""The script that compares variants, as users start it."""

import subprocess
import sys
from pathlib import Path

SCRIPT = Path(__file__).parents[2] / "scripts" / "study.py"


def test_it_saves_and_prints_the_results(tmp_path: Path) -> None:
    command = [sys.executable, str(SCRIPT), "--task", "nav2d", "--episodes", "2"]
    command += ["--horizon", "20", "--variants", "resolution.temperature=1.0"]
    command += ["--out", str(tmp_path / "new")]
    result = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)

    assert result.returncode == 0, result.stderr
    assert "| resolution.temperature=1.0 | 0.0% (0.0% to 65.8%) |" in result.stdout
    files = {path.name for path in (tmp_path / "new").iterdir()}
    assert files == {".lock", "config.json", "episodes.csv", "study.json", "study.png"}


def test_it_says_what_is_wrong(tmp_path: Path) -> None:
    command = [sys.executable, str(SCRIPT), "--task", "nav2d", "--variants", "law.no_such=1"]
    result = subprocess.run(
        [*command, "--out", str(tmp_path)], capture_output=True, text=True, check=False, timeout=300
    )
    assert result.returncode == 2
    assert "variant 'law.no_such=1'" in result.stderr
