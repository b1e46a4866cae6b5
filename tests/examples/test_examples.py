"""Every example runs from a clone, and comes to the end that it announces."""

import importlib.util
import runpy
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))

# The last line that each prints where its claim holds, and what it needs besides the library.
CLAIMS = {
    "01_own_graph": "The robot follows its leader.",
    "02_navigation": "The robot arrived after",
    "03_add_a_goal": "The new goal acts where it has something to say",
    "04_compare_resolutions": "The shipped rule solves the episode.",
    "05_own_object": "The arrow is in place each time.",
    "06_many_robots": "The robots arrive, and none noticed",
    "07_own_arm": "The arm reached every target, within its limits.",
    "08_add_to_a_running_arm": "The arm gave way to the ball, and came back.",
    "09_wheels": "Both robots arrive from every heading, and touch nobody.",
    "10_two_robots": "The robots have changed places, and did not touch.",
}
NEEDED = {
    "04_compare_resolutions": ["pymunk"],
    "05_own_object": ["pymunk"],
    "07_own_arm": ["pytorch_kinematics", "trimesh"],
}


def test_every_example_has_a_claim_here() -> None:
    assert [example.stem for example in EXAMPLES] == list(CLAIMS)


LONG = (
    "04_compare_resolutions",
    "05_own_object",
    "06_many_robots",
    "07_own_arm",
    "08_add_to_a_running_arm",
    "09_wheels",
)
"""Those that take the most time; what they use, others do as well."""


def marked(example: Path) -> Any:
    marks = [pytest.mark.slow] if example.stem in LONG else []
    return pytest.param(example, marks=marks, id=example.stem)


@pytest.mark.parametrize("example", [marked(example) for example in EXAMPLES])
def test_an_example_does_what_it_announces(
    example: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for module in NEEDED.get(example.stem, []):
        if importlib.util.find_spec(module) is None:
            pytest.skip(f"{module} is not installed")

    runpy.run_path(str(example), run_name="__main__")
    last_line = capsys.readouterr().out.strip().splitlines()[-1]
    assert last_line.startswith(CLAIMS[example.stem])


def test_an_example_runs_in_a_process_of_its_own() -> None:
    command = [sys.executable, "examples/03_add_a_goal.py"]
    run = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=300)
    assert run.returncode == 0, run.stderr
    assert CLAIMS["03_add_a_goal"] in run.stdout


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda example: example.stem)
def test_an_example_says_what_one_learns_and_how_to_run_it(example: Path) -> None:
    docstring = example.read_text().split('"""')[1]
    assert "What you learn:" in docstring
    assert f"python examples/{example.name}" in docstring
