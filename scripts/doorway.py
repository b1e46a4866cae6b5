"""When projection matters in a crowd: M discs pass a doorway, each with a goal behind it.

Every disc is a robot that knows where it is, and sees where the others are, but not where they
drive. Its goals are to be at its target, not to touch a wall, and not to touch each of the others:
M + 2 in all, of bounded slopes. Rule, exploration and M are varied, and nothing else. Beside them
drives ORCA, which knows the others' velocities and that they give way as well, if pyrvo is there
(pip install pyrvo). Nothing holds discs that touch; how many do is counted.

Example: python scripts/doorway.py --out runs/doorway
"""

import argparse
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import torch

from aicon_baselines.cli.command_line import RESUMABLE, Command, add_option, at_least, run_command
from aicon_baselines.evaluation.tables import to_markdown
from aicon_torch import NullspaceProjection, Resolution
from doorway_world import DOOR, DT, RADIUS, Array, drive, drive_by_orca, has_orca, starts
from rule_study import RULES as PLAIN
from study_table import fill

TOUCH = 0.01  # m, how far discs overlap before they count as touching
DISCS = (2, 4, 8)

RULES: dict[str, Resolution] = {
    "sum": PLAIN["sum"],
    "sum, explores": NullspaceProjection(projector="none", temperature=None),
    "projection": PLAIN["projection"],
    "projection, explores": NullspaceProjection(temperature=None),
    "as shipped": NullspaceProjection(),
    "steepest path": PLAIN["steepest path"],
}
"""What happens to gradients that meet, without and with exploration."""


class Cell(NamedTuple):
    """What came of one rule with so many discs.

    Attributes:
        seconds: Of a try.
        cleared: In how many tries all discs came through.
        median: Time until the last one was through, of these tries, s.
        untouched: In how many tries nobody touched anything.
        overlap: How far two discs overlapped at most, m.
    """

    seed: int
    tries: int
    seconds: float
    rule: str
    discs: int
    cleared: int
    median: float
    untouched: int
    overlap: float


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare how much is tried, and where it is saved."""
    add_option(parser, "--out", Path("runs/doorway"), "folder of the results")
    add_option(parser, "--tries", 10, "for each cell", type=at_least(1))
    add_option(parser, "--seconds", 30.0, "of a try")
    add_option(parser, "--seed", 300_000, "of the tries", type=at_least(0))


def run(arguments: argparse.Namespace) -> None:
    """Try every rule, save a row for each cell as it comes, and draw them."""
    torch.set_num_threads(1)
    names = [*RULES, *(["ORCA"] if has_orca() else [])]
    settings = (arguments.seed, arguments.tries, arguments.seconds)
    wanted = [(*settings, name, count) for name in names for count in DISCS]
    cells = fill(arguments.out / "cells.csv", Cell, wanted, measure)

    print(f"of {arguments.tries} tries: all through (median, s), nobody touched; largest overlap\n")
    lines = [[name, *(told(cell) for cell in cells if cell.rule == name)] for name in names]
    print(to_markdown(["discs", *map(str, DISCS)], lines))
    draw(cells, names, arguments.out / "doorway.png")
    print(f"\nsaved in {arguments.out}: cells.csv, doorway.png")


def told(cell: Cell) -> str:
    """What came of a cell, for the table."""
    overlap = f"{1e3 * cell.overlap:.0f} mm"
    return f"{cell.cleared} ({cell.median:.0f}), {cell.untouched}; {overlap}"


def measure(seed: int, tries: int, seconds: float, rule: str, count: int) -> list[Cell]:
    """Let so many discs pass in every try."""
    discs, targets = starts(count, tries, seed)
    steps = round(seconds / DT)
    if rule == "ORCA":
        path = drive_by_orca(discs, targets, steps)
    else:
        path = drive(RULES[rule], discs, targets, steps)

    through = np.all(path[..., 0] > RADIUS, axis=-1).reshape(len(path), -1)  # (steps + 1, tries)
    cleared = through[-1]
    times = DT * through.argmax(0)[cleared]
    overlaps = (2 * RADIUS - _distances(path)).clip(min=0.0).max((0, 2))
    beside = (DOOR / 2 - np.abs(path[..., 1])).clip(min=0.0)
    in_walls = (RADIUS - np.hypot(path[..., 0], beside)).clip(min=0.0).max((0, 2))
    untouched = int((np.maximum(overlaps, in_walls) <= TOUCH).sum())
    median = float(np.median(times)) if cleared.any() else float("nan")
    largest = round(float(overlaps.max()), 4)
    return [Cell(seed, tries, seconds, rule, count, int(cleared.sum()), median, untouched, largest)]


def _distances(path: Array) -> Array:
    """Distances of all pairs, ``(steps, tries, pairs)``, m."""
    first, second = np.triu_indices(path.shape[2], 1)
    return np.asarray(np.linalg.norm(path[:, :, first] - path[:, :, second], axis=-1))


def draw(cells: list[Cell], names: list[str], path: Path) -> None:
    """How many tries are cleared, how many untouched, and how long they take, over M."""
    import matplotlib.pyplot as plt

    figure, panels = plt.subplots(1, 3, figsize=(12, 4), layout="constrained")
    for number, name in enumerate(names):
        own = [cell for cell in cells if cell.rule == name]
        counts = [cell.discs for cell in own]
        style: dict[str, Any] = {"marker": "osD^v<>"[number], "label": name, "alpha": 0.8}
        panels[0].plot(counts, [100 * cell.cleared / cell.tries for cell in own], **style)
        panels[1].plot(counts, [100 * cell.untouched / cell.tries for cell in own], **style)
        panels[2].plot(counts, [cell.median for cell in own], **style)

    for panel, title in zip(
        panels,
        ("all discs through, % of the tries", "nobody touched, %", "median time of these, s"),
        strict=True,
    ):
        panel.set_title(title, fontsize=10)
        panel.set_xticks(DISCS)
        panel.set_xlabel("discs")
        panel.set_ylim(bottom=0.0)
    panels[0].legend(fontsize=8)
    figure.savefig(path, dpi=150)


COMMAND = Command(__doc__, add_arguments, run, RESUMABLE)

if __name__ == "__main__":
    run_command(COMMAND)
