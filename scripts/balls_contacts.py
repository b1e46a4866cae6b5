"""Why a ball touched an arm: whether an action was left that kept all bounds, step by step.

Example: python scripts/balls_contacts.py runs/reach_balls --out runs/balls_contacts

It reads the episodes of `aicon compare --task reach` in which the arm was touched, and runs them
again. The least speed by which some bound has to be missed is a linear programme in each step.
"""

import argparse
from collections.abc import Mapping
from itertools import islice
from pathlib import Path
from typing import NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.optimize import linprog
from torch import Tensor

from aicon_baselines.cli.command_line import RESUMABLE, Command, add_option, run_command
from aicon_baselines.evaluation.episodes import run_episodes
from aicon_baselines.evaluation.rows_file import read_rows
from aicon_baselines.evaluation.tables import to_markdown
from aicon_baselines.tasks.reach import TASK
from aicon_torch import Policy, make_policy
from aicon_torch.safety import SafetyBounds
from aicon_torch.safety.bounds import ActuatorSafety, safety_of
from study_table import fill

POLICY = "aicon"

ROUNDING = 1e-3
"""A bound that is missed by less, m/s, is kept."""


class Contact(NamedTuple):
    """The steps up to the first contact of an episode."""

    condition: str
    seed: int
    time: float  # of the contact, s; NaN where none came again
    without: float  # for how long before it no action kept all bounds, s
    least: float  # by how much a bound had to be missed in that time, at the median, m/s
    missed: float  # by how much one was, m/s


def touched(episodes: Path) -> list[tuple[str, int]]:
    """Conditions and seeds of the episodes in which something touched the arm."""
    rows = [row for row in read_rows(episodes) if row.policy == POLICY and row.collision]
    return [(row.condition, row.seed) for row in rows]


def follow(condition: str, seed: int) -> Contact:
    """An episode once more, up to the contact."""
    plain = make_policy("reach", preset=POLICY, **TASK.policy_options(condition))
    policy, safety = plain.compile(), safety_of(plain.model)["a"]
    env = TASK.make_env(1, condition, TASK.horizon)
    start = env.reset(seed=seed)

    least: list[float] = []
    missed: list[float] = []
    for number, step in enumerate(islice(run_episodes(policy, env, start), TASK.horizon)):
        bounds = bounds_of(policy, safety, step.memory)
        least.append(least_miss(bounds))
        missed.append(miss_of(bounds, np.asarray(step.action)[0]))
        if step.info["ball_gap"][0] <= 0.0:
            return _contact(condition, seed, number, least, missed)
    return Contact(condition, seed, np.nan, 0.0, 0.0, 0.0)


def _contact(
    condition: str, seed: int, step: int, least: list[float], missed: list[float]
) -> Contact:
    """What the steps before a contact were like."""
    without = 0
    while without < len(least) and least[-1 - without] > ROUNDING:
        without += 1
    last = slice(len(least) - without, None)
    middle = [float(np.median(values[last])) if without else 0.0 for values in (least, missed)]
    times = (step * TASK.time_step, without * TASK.time_step)
    return Contact(condition, seed, *times, *middle)


def bounds_of(policy: Policy, safety: ActuatorSafety, memory: Mapping[str, Tensor]) -> SafetyBounds:
    """What the safety goals asked of the last action."""
    values = dict(policy.trace(dict(memory)).values)
    values["dt"] = torch.full((1, 1), TASK.time_step, dtype=torch.float64)
    within, _, _ = safety.bounds(
        values, torch.ones(1, len(policy.model.goals), dtype=torch.float64)
    )
    return within


def least_miss(within: SafetyBounds) -> float:
    """The least speed by which the worst bound is missed, m/s: min t with n·a ≥ b − t."""
    slopes, bounds = within.slopes[0].numpy(), within.bounds[0].numpy()
    count = slopes.shape[1]
    box = list(zip(within.low[0].tolist(), within.high[0].tolist(), strict=True))
    found = linprog(
        np.append(np.zeros(count), 1.0),
        A_ub=np.column_stack((-slopes, -np.ones(len(slopes)))),
        b_ub=-bounds,
        bounds=[*box, (0.0, None)],
    )
    return np.nan if found.x is None else float(found.x[-1])


def miss_of(within: SafetyBounds, action: NDArray[np.float64]) -> float:
    """By how much the worst bound is missed by an action, m/s."""
    slopes, bounds = within.slopes[0].numpy(), within.bounds[0].numpy()
    return max(0.0, float((bounds - slopes @ action).max()))


def run(arguments: argparse.Namespace) -> None:
    """Follow each contact, and print a table."""
    torch.set_num_threads(1)
    wanted = touched(arguments.folder / "episodes.csv")
    table = arguments.out / "contacts.csv"
    found = fill(table, Contact, wanted, lambda *one: [follow(*one)], "contacts")

    header = ["condition", "seed", "contact, s", "without an action for, s"]
    header += ["a bound had to be missed by, m/s", "and was by, m/s"]
    lines = []
    for row in found:
        numbers = (row.time, row.without, row.least, row.missed)
        lines.append([row.condition, str(row.seed), *(f"{number:.2f}" for number in numbers)])
    print(to_markdown(header, lines))


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare whose contacts are followed."""
    parser.add_argument("folder", type=Path, help="of a comparison, with its episodes.csv")
    add_option(parser, "--out", Path("runs/balls_contacts"), "folder of the results")


COMMAND = Command(__doc__, add_arguments, run, RESUMABLE)

if __name__ == "__main__":
    run_command(COMMAND)
