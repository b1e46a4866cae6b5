from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("lerobot")

from aicon_baselines.agents.diffusion.agent import Agent
from aicon_baselines.cli.main import main
from aicon_baselines.evaluation.rows_file import read_rows

SHORT = ("--task", "pusht", "--seed", 1000, "--horizon", 3, "--episodes", 2)
CONDITIONS = ("--conditions", "deterministic", "noise_2")
BESIDES = "without_foresight"  # one gradient a step
SAMPLER = ("--sampler", "DDPM", "--inference-steps", 3)


def compare(folder: Path, *arguments: object) -> list[Any]:
    """Return the rows of a comparison."""
    options = (*SHORT, *CONDITIONS, *SAMPLER, "--no-compile", "--out", folder, *arguments)
    main(["compare", *map(str, options)])
    return read_rows(folder / "episodes.csv")


def test_rows_do_not_depend_on_how_they_were_run(policy: Path, tmp_path: Path) -> None:
    diffusion = ("--diffusion-path", policy)
    rows = compare(tmp_path / "both", "--policies", "diffusion", BESIDES, *diffusion)
    students = [row for row in rows if row.policy != BESIDES]
    assert {row.policy for row in students} == {Agent(policy, "DDPM", 3).name}
    assert len(students) == 4

    # Another run, as if it had been stopped after the first row.
    compare(tmp_path / "stopped", "--policies", BESIDES)
    lines = (tmp_path / "both" / "episodes.csv").read_text().splitlines(keepends=True)
    (tmp_path / "stopped" / "episodes.csv").write_text("".join(lines[:2]))

    resumed = compare(tmp_path / "stopped", "--policies", "diffusion", *diffusion)
    assert [row for row in resumed if row.policy != BESIDES] == students
