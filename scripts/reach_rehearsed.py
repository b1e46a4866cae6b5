"""What rehearsal buys an arm with nothing about it: when its tip arrives, computing counted.

Joints move as they are told to, without physics, from where the environment starts them to its
targets at the same seeds.

Example: python scripts/reach_rehearsed.py --conditions ur5_pose_home --out runs/reach_rehearsed
"""

import argparse
import math
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import torch
from tqdm import tqdm

from aicon_baselines.cli.command_line import RESUMABLE, Command, add_option, run_command
from aicon_baselines.evaluation.tables import to_markdown
from aicon_baselines.tasks.reach import TASK
from aicon_torch.models import make_policy
from clutter import DT, ESCAPES, NEAR, STRAIGHT, draw, rehearsed, rows_of, share_of
from reach_study import Targets, targets
from study_table import read, write

HORIZON = 20.0


class Row(NamedTuple):
    """What became of a target."""

    condition: str
    policy: str
    seed: int
    time: float  # s, with what it thought; NaN where it did not arrive
    thought: float  # s of computing beyond a step's time
    detours: int


def follow(agent: Any, found: Targets, number: int) -> tuple[float, float, int]:
    """When the tip is at one of the targets, what it thought until then, and its detours."""
    one = torch.tensor([number])
    seen, place = rows_of(found.seen, one), found.places[one]
    memory: Any = None
    thought, detours = 0.0, 0
    for step in range(round(HORIZON / DT)):
        missing, angle = found.pose.distance(
            found.pose.of_frame(found.robot.chain(seen["q"])), place
        )
        if missing < NEAR and angle < STRAIGHT:
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
    arguments.out.mkdir(parents=True, exist_ok=True)
    seeds = range(arguments.seed, arguments.seed + arguments.episodes)
    for condition in arguments.conditions:
        table = arguments.out / f"{condition}.csv"
        known = {(row.policy, row.seed) for row in read(table, Row)}
        found = targets(condition, seeds)
        policy = make_policy("reach", **TASK.policy_options(condition)).compile()

        for name, agent in {"aicon": policy, "rehearsed": rehearsed(policy)}.items():
            missing = [seed for seed in seeds if (name, seed) not in known]
            for seed in tqdm(missing, desc=f"{condition}, {name}", disable=None):
                write(table, Row(condition, name, seed, *follow(agent, found, seed - seeds.start)))

        rows = [row for row in read(table, Row) if row.seed in seeds]
        report(rows)
        draw(table, rows, HORIZON)


def report(rows: Sequence[Row]) -> None:
    """Print a table."""
    header = ["condition", "policy", "arrive", "%", "median time", "95th of 100", "thought, median"]
    lines = []
    for name in dict.fromkeys(row.policy for row in rows):
        own = [row for row in rows if row.policy == name]
        times = np.array([row.time for row in own])
        count = int((times <= HORIZON).sum())

        # One that does not arrive is later than all that do.
        late = np.where(np.isnan(times), np.inf, times)
        middle, last = np.percentile(late, (50, 95), method="lower").tolist()
        thought = f"{np.median([row.thought for row in own]):.2f} s"
        lines.append([own[0].condition, name, f"{count} of {len(own)}"])
        lines[-1] += [share_of(count, len(own)), f"{middle:.2f} s", f"{last:.2f} s", thought]
    print(to_markdown(header, lines))

    for row in rows:
        if not row.time <= HORIZON:
            print(row)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what is run."""
    parser.add_argument(
        "--conditions", nargs="+", choices=TASK.conditions, required=True, metavar="NAME"
    )
    add_option(parser, "--episodes", 100, "targets of each condition")
    add_option(parser, "--seed", 1000, "of the first target")
    parser.add_argument("--out", type=Path, default=Path("runs/reach_rehearsed"))


COMMAND = Command(__doc__, add_arguments, run, RESUMABLE)

if __name__ == "__main__":
    run_command(COMMAND)
