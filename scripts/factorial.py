"""What carries pushing: each combination of rule, exploration, law and speed, on the same episodes.

Example: python scripts/factorial.py --task pusht --jobs 2 --out runs/factorial

The rules are the sum of the gradients, their weighted sum and the projection; each with exploration
and without, with one gradient a step and with foresight, on the arm that of a step and that of its
reaction, at several speeds. The folder gets the rows of each speed in a folder of its own,
`factorial.csv`, `factorial.md` and `factorial.png`. The same command goes on where a stopped run
was.
"""

import argparse
import csv
from collections.abc import Mapping, Sequence
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
from aicon_baselines.evaluation.errors import ComparisonError
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


class Setting(NamedTuple):
    """What is combined in a task.

    Attributes:
        condition: The condition.
        laws: Options of each action law, by its name.
        speed: The option that limits the speed of the pusher.
        unit: Of the speeds below, by the option's.
        unit_name: Its name.
        horizons: The speeds, and the steps that an episode may take then.
        soon: A shorter horizon, steps.
        seed: First seed.
        episodes: How many.
    """

    condition: str
    laws: Mapping[str, Mapping[str, Any]]
    speed: str
    unit: float
    unit_name: str
    horizons: Mapping[int, int]
    soon: int
    seed: int
    episodes: int


SETTINGS = {
    "pusht": Setting(
        condition="deterministic",
        laws={"one gradient": {"law": DirectDescent()}, "foresight": {"law": Foresight()}},
        speed="max_speed",
        unit=PIXEL,
        unit_name="px/s",
        horizons={25: 6000, 100: 2000, 400: 1000, 800: 1000},
        soon=300,  # gym-pusht's own
        seed=200,
        episodes=200,
    ),
    "arm_push": Setting(
        condition="true_pose",
        laws={
            "one gradient": {"law": DirectDescent()},
            "foresight of a step": {"law": Foresight(dither=0.0)},
            "foresight": {},
        },
        speed="limits.tip_speed",
        unit=1e-3,
        unit_name="mm/s",
        horizons={50: 18000, 400: 6000},
        soon=3000,
        seed=0,
        episodes=20,
    ),
}


class Cell(NamedTuple):
    """One combination, and the share of its episodes that succeed within each horizon."""

    rule: str
    exploration: str
    law: str
    speed: int
    episodes: int
    horizon: int
    within_soon: float
    within_horizon: float


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the task, what is combined and the episodes."""
    parser.add_argument("--task", choices=SETTINGS, required=True)
    parser.add_argument("--rules", nargs="+", choices=RULES, default=[*RULES])
    parser.add_argument("--laws", nargs="+", help="default: all of the task")
    parser.add_argument("--speeds", nargs="+", type=int, help="default: all of the task")
    parser.add_argument("--episodes", type=int, help="seeds (default: the task's)")
    parser.add_argument("--seed", type=int, help="first seed (default: the task's)")
    parser.add_argument("--jobs", type=int, default=1, help="processes (default: 1)")
    parser.add_argument("--out", type=Path, required=True, help="folder of the results")


def run(arguments: argparse.Namespace) -> None:
    """Run what is missing, speed by speed; write the table and the picture after each."""
    setting = SETTINGS[arguments.task]
    speeds = arguments.speeds or [*setting.horizons]
    if unknown := set(speeds) - set(setting.horizons):
        valid = ", ".join(map(str, setting.horizons))
        raise ComparisonError(
            f"--speeds {min(unknown)}: expected some of {valid} ({setting.unit_name})"
        )
    laws = arguments.laws or [*setting.laws]
    if unknown_laws := set(laws) - set(setting.laws):
        valid = ", ".join(map(repr, setting.laws))
        raise ComparisonError(f"--laws {min(unknown_laws)!r}: expected some of {valid}")

    cells: list[Cell] = []
    for speed in speeds:
        cells += run_speed(speed, laws, setting, arguments)
        write_cells(arguments.out / "factorial.csv", cells)
        draw(arguments.out / "factorial.png", cells, setting)

    table = to_table(cells, setting)
    with replacing(arguments.out / "factorial.md") as path:
        path.write_text(table + "\n", encoding="utf-8")
    print(table)


def run_speed(
    speed: int, laws: Sequence[str], setting: Setting, arguments: argparse.Namespace
) -> list[Cell]:
    """Run every combination at one speed."""
    task = load(arguments.task)
    combinations = {
        ", ".join(names): names for names in product(arguments.rules, EXPLORATION, laws)
    }
    policies = {
        name: compiled(factory(task.name, "aicon", **options_of(names, speed, setting)))
        for name, names in combinations.items()
    }

    config = configure(
        task,
        seed=setting.seed if arguments.seed is None else arguments.seed,
        episodes=setting.episodes if arguments.episodes is None else arguments.episodes,
        conditions=[setting.condition],
        horizon=setting.horizons[speed],
    )
    with RunFolder.open(arguments.out / f"speed_{speed}", config) as folder:
        compare(task, policies, folder, arguments.jobs)
        rows = list(folder.rows())

    return [
        to_cell(names, speed, setting, [row for row in rows if row.policy == name])
        for name, names in combinations.items()
    ]


def options_of(names: tuple[str, ...], speed: int, setting: Setting) -> dict[str, Any]:
    """Options of one combination, on top of the policy that is shipped."""
    rule, exploration, law = names
    fastest = {setting.speed: speed * setting.unit}
    return {**RULES[rule], **EXPLORATION[exploration], **setting.laws[law], **fastest}


def to_cell(names: tuple[str, ...], speed: int, setting: Setting, rows: list[Row]) -> Cell:
    """Count the successes of one combination."""
    rule, exploration, law = names
    solved = np.array([row.success for row in rows])
    soon = np.array([row.steps is not None and row.steps <= setting.soon for row in rows])
    return Cell(
        rule,
        exploration,
        law,
        speed,
        episodes=len(rows),
        horizon=setting.horizons[speed],
        within_soon=float((solved & soon).mean()),
        within_horizon=float(solved.mean()),
    )


def write_cells(path: Path, cells: list[Cell]) -> None:
    """Write a line for each combination."""
    with replacing(path) as new, new.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(Cell._fields)
        writer.writerows(cells)


def to_table(cells: list[Cell], setting: Setting) -> str:
    """A row for each rule, with and without exploration; a column for each law and speed."""
    columns = list(dict.fromkeys((cell.law, cell.speed) for cell in cells))
    names = (f"{law}, {speed} {setting.unit_name}" for law, speed in columns)

    lines = []
    for rule, exploration in dict.fromkeys((cell.rule, cell.exploration) for cell in cells):
        found = {
            (cell.law, cell.speed): (cell.within_soon, cell.within_horizon)
            for cell in cells
            if (cell.rule, cell.exploration) == (rule, exploration)
        }
        shares = [" / ".join(f"{100 * share:.1f}" for share in found[column]) for column in columns]
        lines.append([rule, exploration, *shares])
    return to_markdown(["rule", "", *names], lines)


def draw(path: Path, cells: list[Cell], setting: Setting) -> None:
    """Save a picture: success at the long horizon, a panel for each law."""
    laws = list(dict.fromkeys(cell.law for cell in cells))
    figure = Figure(figsize=(1.0 + 4.0 * len(laws), 3.6), layout="constrained")
    FigureCanvasAgg(figure)
    rows = list(dict.fromkeys((cell.rule, cell.exploration) for cell in cells))
    speeds = list(dict.fromkeys(cell.speed for cell in cells))

    for axes, law in zip(
        figure.subplots(1, len(laws), sharey=True, squeeze=False)[0], laws, strict=True
    ):
        share = {
            (cell.rule, cell.exploration, cell.speed): cell.within_horizon
            for cell in cells
            if cell.law == law
        }
        values = 100 * np.array([[share[*row, speed] for speed in speeds] for row in rows])
        axes.imshow(values, cmap="Blues", vmin=0, vmax=100, aspect="auto")

        for (line, column), value in np.ndenumerate(values):
            color = "white" if value > 60 else "black"
            axes.text(column, line, f"{value:.3g}", ha="center", va="center", color=color)
        axes.set_xticks(range(len(speeds)), [f"{speed}" for speed in speeds])
        axes.set_yticks(range(len(rows)), [f"{rule}, {how}" for rule, how in rows])
        axes.set_xlabel(f"speed of the pusher, {setting.unit_name}")
        axes.set_title(f"{law}: success, %")

    with replacing(path) as new:
        figure.savefig(new, dpi=150, format="png")


COMMAND = Command(__doc__, add_arguments, run, RESUMABLE)

if __name__ == "__main__":
    run_command(COMMAND)
