"""When projection matters on an arm: N of its points follow a reference that dips behind a wall.

A Panda whose joints are read is to have N of its points where those of a reference arm are, as in
teleoperation or when a motion is taken over from a person; every point's goal has the slope 1. No
point is to come behind a wall, whose cost has a bounded slope as well, and the reference does.
Rule, number of points and slope of the wall are varied, and nothing else. A try is clean if no
point is more than 5 mm behind the wall at any time after the first second.

The negative control has the wall where the reference only comes near it, so that everything can be
had at once: nothing is to be gained there, and what each rule and each exploration loses is told.

Example: python scripts/retarget.py --out runs/retarget
"""

import argparse
from pathlib import Path
from typing import NamedTuple

import numpy as np
import torch

from aicon_baselines.cli.command_line import RESUMABLE, Command, add_option, at_least, run_command
from aicon_baselines.evaluation.tables import to_markdown
from aicon_torch import Exploration, NullspaceProjection, Resolution
from retarget_world import DT, MARGIN, follow, make_policy, references
from rule_study import RULES
from study_table import fill

SETTLES = 1.0  # s, after which errors count
BEHIND = 0.005  # m, from where on a point counts as behind it
POINTS = (1, 2, 4, 8, 16)
SLOPES = (1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0, 24.0, 32.0)
DIPS = 0.4  # share of the time in which the reference is behind the wall

EXPLORERS: dict[str, Resolution] = {
    "sum, explores": NullspaceProjection(projector="none", temperature=None),
    "as in the text": NullspaceProjection.as_in_paper(),
    "as shipped": NullspaceProjection(),
    "unless it tracks": NullspaceProjection(exploration=Exploration(unless_tracking=True)),
}
"""Rules with exploration: the text's, the shipped one, and one that lets tracking be."""


class Cell(NamedTuple):
    """What came of one rule with so many points and one slope.

    Attributes:
        seconds: Of a try.
        world: "dips", or "near" for the negative control.
        clean: How many of the tries were clean.
        behind: Share of the time more than 5 mm behind the wall.
        free: Mean error of the points while the reference is before the wall, m.
        held: The same while it is behind it, m.
    """

    seed: int
    tries: int
    seconds: float
    world: str
    rule: str
    points: int
    slope: float
    clean: int
    behind: float
    free: float
    held: float


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare how much is tried, and where it is saved."""
    add_option(parser, "--out", Path("runs/retarget"), "folder of the results")
    add_option(parser, "--tries", 10, "for each cell", type=at_least(1))
    add_option(parser, "--seconds", 8.0, "of a try")
    add_option(parser, "--seed", 300_000, "of the tries", type=at_least(0))


def run(arguments: argparse.Namespace) -> None:
    """Try every rule in both worlds, save a row for each cell as it comes, and draw them."""
    torch.set_num_threads(1)
    worlds = [("dips", rule, count) for rule in RULES for count in POINTS]
    worlds += [("near", rule, 8) for rule in (*RULES, *EXPLORERS)]
    worlds += [("dips", rule, 8) for rule in EXPLORERS]
    settings = (arguments.seed, arguments.tries, arguments.seconds)
    wanted = [(*settings, *world) for world in worlds]
    cells = fill(arguments.out / "cells.csv", Cell, wanted, measure)

    report(cells, arguments.tries)
    draw(cells, arguments.out / "retarget.png")
    print(f"\nsaved in {arguments.out}: cells.csv, retarget.png")


def measure(seed: int, tries: int, seconds: float, world: str, rule: str, count: int) -> list[Cell]:
    """Every slope and every try at once, as rows of one batch."""
    joints, points = references(count, tries, seconds, seed)
    slopes = SLOPES if world == "dips" and rule in RULES else (3.0,)
    deepest = points[..., 0].max(-1)
    if world == "dips":
        walls = np.quantile(deepest, 1.0 - DIPS, axis=0)
    else:
        walls = deepest.max(0) + MARGIN  # the reference comes as near as to where it costs

    copies = len(slopes)
    depths, errors, _ = follow(
        make_policy({**RULES, **EXPLORERS}[rule], count),
        np.tile(joints, (1, copies, 1)),
        np.tile(points, (1, copies, 1, 1)),
        np.tile(walls, copies)[:, None],
        np.repeat(slopes, tries)[:, None],
    )

    begin = round(SETTLES / DT)
    is_behind = (deepest > walls)[begin:]
    cells = []
    for index, slope in enumerate(slopes):
        own = slice(index * tries, (index + 1) * tries)
        depth, error = depths[begin:, own], errors[begin:, own]
        clean, behind = int((depth.max(0) <= BEHIND).sum()), float((depth > BEHIND).mean())
        free = float(error[~is_behind].mean())
        held = float(error[is_behind].mean()) if is_behind.any() else 0.0
        told = (round(value, 5) for value in (behind, free, held))
        cells.append(Cell(seed, tries, seconds, world, rule, count, slope, clean, *told))
    return cells


def least_slope(cells: list[Cell], rule: str, count: int) -> Cell | None:
    """The cell of the least slope from which on every try is clean; None where there is none."""
    own = [cell for cell in cells if cell[3:6] == ("dips", rule, count)]
    least = None
    for cell in sorted(own, key=lambda cell: -cell.slope):
        if cell.clean < cell.tries:
            break
        least = cell
    return least


def report(cells: list[Cell], tries: int) -> None:
    """Print the least slope that holds, with the errors there, and the negative control."""
    print(f"least slope with all of {tries} tries clean; error before and behind the wall, mm\n")
    lines = [
        [rule, *(_told(least_slope(cells, rule, count)) for count in POINTS)] for rule in RULES
    ]
    print(to_markdown(["points", *map(str, POINTS)], lines))

    print("\n8 points, slope 3: error, mm, where all can be had, and before and behind the wall\n")
    lines = []
    for rule in (*RULES, *EXPLORERS):
        near, dips = (
            next(cell for cell in cells if cell[3:7] == (world, rule, 8, 3.0))
            for world in ("near", "dips")
        )
        errors = [f"{1e3 * error:.1f}" for error in (near.free, dips.free, dips.held)]
        lines.append([rule, *errors, f"{dips.clean}/{dips.tries}", f"{100 * dips.behind:.0f} %"])
    print(
        to_markdown(["rule", "all can be had", "before", "behind", "clean", "time behind"], lines)
    )


def _told(cell: Cell | None) -> str:
    return f"{cell.slope:g} ({1e3 * cell.free:.0f}, {1e3 * cell.held:.0f})" if cell else "none"


def draw(cells: list[Cell], path: Path) -> None:
    """The least slope that holds over the number of points, and the errors beside it."""
    import matplotlib.pyplot as plt

    figure, (slopes, errors) = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
    for number, rule in enumerate(RULES):
        held = {count: least_slope(cells, rule, count) for count in POINTS}
        known = {count: cell for count, cell in held.items() if cell is not None}
        style = {"marker": "osD^v"[number], "label": rule, "alpha": 0.8}
        slopes.plot(list(known), [cell.slope for cell in known.values()], **style)
        errors.plot(list(known), [1e3 * cell.free for cell in known.values()], **style)

    for panel in (slopes, errors):
        panel.set_xscale("log", base=2)
        panel.set_xticks(POINTS, POINTS)
        panel.set_xlabel("points that follow")
    slopes.set_yscale("log", base=2)
    slopes.set_yticks(SLOPES, [f"{slope:g}" for slope in SLOPES])
    slopes.set_ylabel("least slope of the wall that holds")
    errors.set_ylabel("error of the points there, before the wall, mm")
    errors.set_ylim(bottom=0.0)
    slopes.legend(fontsize=8)
    figure.savefig(path, dpi=150)


COMMAND = Command(__doc__, add_arguments, run, RESUMABLE)

if __name__ == "__main__":
    run_command(COMMAND)
