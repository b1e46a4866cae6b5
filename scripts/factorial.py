"""What carries pushT: every combination of rule, exploration, law and speed, on the same episodes.

Example: python scripts/factorial.py --jobs 2 --out runs/factorial

The rules are the sum of the gradients, their weighted sum and the projection; each with exploration
and without, with one gradient a step and with foresight, at four speeds. The folder gets the rows
of each speed in a folder of its own, `factorial.csv`, `factorial.md` and `factorial.png`. The same
command goes on where a stopped run was.
"""

import argparse
import csv
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from aicon_baselines.agents.registry import compiled, factory
from aicon_baselines.cli.command_line import RESUMABLE, Command, run_command
from aicon_baselines.evaluation.comparison import compare
from aicon_baselines.evaluation.config import configure
from aicon_baselines.evaluation.row import Row
from aicon_baselines.evaluation.run_folder import RunFolder
from aicon_baselines.evaluation.tables import to_markdown
from aicon_baselines.files import replacing
from aicon_baselines.tasks import load
from aicon_torch.control import DirectDescent, Foresight
from aicon_torch.models.pusht import PIXEL

RULES: dict[str, dict[str, Any]] = {
    "sum": {"resolution.projector": "none", "resolution.temperature": None},
    "weighted sum": {"resolution.projector": "none"},
    "projection": {},
}
"""Options of the rule for gradients that meet; their sum is weighted by their own lengths."""

EXPLORATION: dict[str, dict[str, Any]] = {
    "no exploration": {"resolution.exploration": None},
    "exploration": {},
}

LAWS = {"one gradient": DirectDescent(), "foresight": Foresight()}

HORIZONS = {25: 6000, 100: 2000, 400: 1000, 800: 1000}
"""Speeds of the pusher, px/s, and the steps that an episode may take then."""

SOON = 300
"""Steps of gym-pusht's own limit, the shorter of two horizons."""


class Cell(NamedTuple):
    """One combination, and the share of its episodes that succeed within each horizon."""

    rule: str
    exploration: str
    law: str
    speed: int
    episodes: int
    horizon: int
    within_300: float
    within_horizon: float


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the speeds and the episodes."""
    parser.add_argument("--speeds", nargs="+", type=int, choices=HORIZONS, default=[*HORIZONS])
    parser.add_argument("--episodes", type=int, default=200, help="seeds (default: 200)")
    parser.add_argument("--seed", type=int, default=200, help="first seed (default: 200)")
    parser.add_argument("--jobs", type=int, default=1, help="processes (default: 1)")
    parser.add_argument("--out", type=Path, required=True, help="folder of the results")


def run(arguments: argparse.Namespace) -> None:
    """Run what is missing, speed by speed; write the table and the picture after each."""
    cells: list[Cell] = []
    for speed in arguments.speeds:
        cells += run_speed(speed, arguments)
        write_cells(arguments.out / "factorial.csv", cells)
        draw(arguments.out / "factorial.png", cells)

    table = to_table(cells)
    with replacing(arguments.out / "factorial.md") as path:
        path.write_text(table + "\n", encoding="utf-8")
    print(table)


def run_speed(speed: int, arguments: argparse.Namespace) -> list[Cell]:
    """Run every combination at one speed."""
    task = load("pusht")
    combinations = {", ".join(names): names for names in product(RULES, EXPLORATION, LAWS)}
    policies = {
        name: compiled(factory(task.name, "aicon", **options_of(*names, speed)))
        for name, names in combinations.items()
    }

    config = configure(
        task, seed=arguments.seed, episodes=arguments.episodes, horizon=HORIZONS[speed]
    )
    with RunFolder.open(arguments.out / f"speed_{speed}", config) as folder:
        compare(task, policies, folder, arguments.jobs)
        rows = list(folder.rows())

    return [
        to_cell(names, speed, [row for row in rows if row.policy == name])
        for name, names in combinations.items()
    ]


def options_of(rule: str, exploration: str, law: str, speed: int) -> dict[str, Any]:
    """Options of one combination, on top of the policy that is shipped."""
    chosen = {"law": LAWS[law], "max_speed": speed * PIXEL}
    return RULES[rule] | EXPLORATION[exploration] | chosen


def to_cell(names: tuple[str, ...], speed: int, rows: list[Row]) -> Cell:
    """Count the successes of one combination."""
    rule, exploration, law = names
    solved = np.array([row.success for row in rows])
    soon = np.array([row.steps is not None and row.steps <= SOON for row in rows])
    return Cell(
        rule,
        exploration,
        law,
        speed,
        episodes=len(rows),
        horizon=HORIZONS[speed],
        within_300=float((solved & soon).mean()),
        within_horizon=float(solved.mean()),
    )


def write_cells(path: Path, cells: list[Cell]) -> None:
    """Write a line for each combination."""
    with replacing(path) as new, new.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(Cell._fields)
        writer.writerows(cells)


def to_table(cells: list[Cell]) -> str:
    """A row for each rule, with and without exploration; a column for each law and speed."""
    columns = list(dict.fromkeys((cell.law, cell.speed) for cell in cells))
    head = ["rule", "", *(f"{law}, {speed} px/s" for law, speed in columns)]

    lines = []
    for rule, exploration in product(RULES, EXPLORATION):
        found = {
            (cell.law, cell.speed): f"{100 * cell.within_300:.1f} / {100 * cell.within_horizon:.1f}"
            for cell in cells
            if (cell.rule, cell.exploration) == (rule, exploration)
        }
        lines.append([rule, exploration, *(found[column] for column in columns)])
    return to_markdown(head, lines)


def draw(path: Path, cells: list[Cell]) -> None:
    """Save a picture: success at the long horizon, a panel for each law."""
    figure = Figure(figsize=(9.0, 3.6), layout="constrained")
    FigureCanvasAgg(figure)
    rows = list(product(RULES, EXPLORATION))
    speeds = list(dict.fromkeys(cell.speed for cell in cells))

    for axes, law in zip(figure.subplots(1, 2, sharey=True), LAWS, strict=True):
        share = {
            (cell.rule, cell.exploration, cell.speed): cell.within_horizon
            for cell in cells
            if cell.law == law
        }
        values = 100 * np.array([[share[*row, speed] for speed in speeds] for row in rows])
        axes.imshow(values, cmap="Blues", vmin=0, vmax=100, aspect="auto")

        for (line, column), value in np.ndenumerate(values):
            color = "white" if value > 60 else "black"
            axes.text(column, line, f"{value:.0f}", ha="center", va="center", color=color)
        axes.set_xticks(range(len(speeds)), [f"{speed}" for speed in speeds])
        axes.set_yticks(range(len(rows)), [f"{rule}, {how}" for rule, how in rows])
        axes.set_xlabel("speed of the pusher, px/s")
        axes.set_title(f"{law}: success, %")

    with replacing(path) as new:
        figure.savefig(new, dpi=150, format="png")


COMMAND = Command(__doc__, add_arguments, run, RESUMABLE)

if __name__ == "__main__":
    run_command(COMMAND)
