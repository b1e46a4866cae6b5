"""What rehearsal buys an arm with nothing about it: when its tip arrives, computing counted.

Joints move as they are told to, without physics, from where the environment starts them to its
targets at the same seeds.

Example: python scripts/reach_rehearsed.py --conditions ur5_pose_home --out runs/reach_rehearsed
"""

import argparse
import math
import time
from collections.abc import Sequence
from itertools import product
from operator import attrgetter
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import torch

from aicon_baselines.cli.command_line import RESUMABLE, Command, add_option, run_command
from aicon_baselines.evaluation.statistics import group_rows
from aicon_baselines.evaluation.tables import to_markdown
from aicon_baselines.tasks.reach import TASK
from aicon_torch.models import make_policy
from clutter import DT, ESCAPES, draw, rehearsed, rows_of, share_of
from reach_study import Targets, add_targets, targets
from study_table import fill

HORIZON = 20.0


class Row(NamedTuple):
    """What became of a target."""

    condition: str
    policy: str
    seed: int
    time: float  # s, with what it thought; NaN where it did not arrive
    thought: float  # s of computing beyond a step's time
    detours: int

    @property
    def is_solved(self) -> bool:
        """Whether it arrived."""
        return self.time <= HORIZON


def follow(agent: Any, found: Targets, number: int) -> tuple[float, float, int]:
    """When the tip is at one of the targets, what it thought until then, and its detours."""
    one = torch.tensor([number])
    found = found._replace(seen=rows_of(found.seen, one), places=found.places[one])
    seen, memory = found.seen, None
    thought, detours = 0.0, 0
    for step in range(round(HORIZON / DT)):
        if found.has(seen["q"]):
            return step * DT + thought, thought, detours

        before = time.process_time()
        action, memory = agent.predict(seen, memory)
        thought += max(0.0, time.process_time() - before - DT)
        detours = int(memory[ESCAPES][0])
        seen = {**seen, "q": seen["q"] + DT * action}
    return math.nan, thought, detours


def run(arguments: argparse.Namespace) -> None:
    """Run what is not yet in the table, and report."""
    torch.set_num_threads(1)
    seeds = range(arguments.seed, arguments.seed + arguments.episodes)
    for condition in arguments.conditions:
        table = arguments.out / f"{condition}.csv"
        rows = rows_of_condition(condition, seeds, table)
        report(rows)
        draw(table, rows, HORIZON)


def rows_of_condition(condition: str, seeds: range, table: Path) -> list[Row]:
    """What becomes of the targets of a condition."""
    found = targets(condition, seeds)
    policy = make_policy("reach", **TASK.policy_options(condition)).compile()
    policy.predict(rows_of(found.seen, torch.tensor([0])))  # it compiles before the time counts
    agents = {"aicon": policy, "rehearsed": rehearsed(policy)}

    def measure(condition: str, name: str, seed: int) -> list[Row]:
        return [Row(condition, name, seed, *follow(agents[name], found, seeds.index(seed)))]

    return fill(table, Row, list(product([condition], agents, seeds)), measure, condition)


def report(rows: Sequence[Row]) -> None:
    """Print a table."""
    header = ["condition", "policy", "arrive", "%", "median time", "95th of 100", "thought, median"]
    lines = []
    for name, own in group_rows(rows, attrgetter("policy")).items():
        times = np.array([row.time for row in own])
        count = sum(row.is_solved for row in own)

        # One that does not arrive is later than all that do.
        late = np.where(np.isnan(times), np.inf, times)
        middle, last = np.percentile(late, (50, 95), method="lower").tolist()
        thought = f"{np.median([row.thought for row in own]):.2f} s"
        lines.append([own[0].condition, name, f"{count} of {len(own)}"])
        lines[-1] += [share_of(count, len(own)), f"{middle:.2f} s", f"{last:.2f} s", thought]
    print(to_markdown(header, lines))

    for row in rows:
        if not row.is_solved:
            print(row)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what is run."""
    add_targets(parser, 100)
    add_option(parser, "--out", Path("runs/reach_rehearsed"), "folder of the results")


COMMAND = Command(__doc__, add_arguments, run, RESUMABLE)

if __name__ == "__main__":
    run_command(COMMAND)
