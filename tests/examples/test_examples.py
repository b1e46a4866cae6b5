"""Every example runs from a clone, and comes to the end that it announces."""

import importlib.util
import runpy
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import torch

ROOT = Path(__file__).parents[2]
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))

# The last line that each prints where its claim holds, and what it needs besides the library.
CLAIMS = {
    "01_own_graph": "The robot follows its leader.",
    "02_navigation": "The robot arrived after",
    "03_compare_resolutions": "The shipped rule solves the episode.",
    "04_many_robots": "The robots arrive, and none noticed",
    "05_own_arm": "The arm reached every target, within its limits.",
    "06_add_to_a_running_arm": "The arm gave way to the ball, and came back.",
    "07_two_robots": "The robots have changed places, and did not touch.",
    "08_learned_motion": "What was learned brings the robots to their target.",
    "nano": "The disc is out of the trap and at its target",
}
NEEDED = {
    "03_compare_resolutions": ["pymunk"],
    "05_own_arm": ["mujoco", "pytorch_kinematics", "trimesh"],
}


def test_every_example_has_a_claim_here() -> None:
    assert [example.stem for example in EXAMPLES] == list(CLAIMS)


LONG = (
    "01_own_graph",
    "03_compare_resolutions",
    "04_many_robots",
    "05_own_arm",
    "06_add_to_a_running_arm",
    "07_two_robots",
    "08_learned_motion",
    "nano",
)
"""Those that take the most time; what they use, others do as well."""


APART = "02_navigation"
"""The one that runs in a process of its own; the others run in that of the tests."""


def marked(example: Path) -> Any:
    marks = [pytest.mark.slow] if example.stem in LONG else []
    return pytest.param(example, marks=marks, id=example.stem)


@pytest.mark.parametrize("example", [marked(e) for e in EXAMPLES if e.stem != APART])
def test_an_example_does_what_it_announces(
    example: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for module in NEEDED.get(example.stem, []):
        if importlib.util.find_spec(module) is None:
            pytest.skip(f"{module} is not installed")

    precision = torch.get_default_dtype()
    try:
        runpy.run_path(str(example), run_name="__main__")
    finally:
        torch.set_default_dtype(precision)
    last_line = capsys.readouterr().out.strip().splitlines()[-1]
    assert last_line.startswith(CLAIMS[example.stem])


def test_an_example_runs_in_a_process_of_its_own() -> None:
    command = [sys.executable, f"examples/{APART}.py"]
    run = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=300)
    assert run.returncode == 0, run.stderr
    assert run.stdout.strip().splitlines()[-1].startswith(CLAIMS[APART])


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda example: example.stem)
def test_an_example_says_what_one_learns_and_how_to_run_it(example: Path) -> None:
    docstring = example.read_text().split('"""')[1]
    assert "What you learn:" in docstring
    assert f"python examples/{example.name}" in docstring
