"""Targets that an arm cannot reach: does it come as near as it can, and say so?

The targets of the environment are moved out of reach, and beside them are those that can be
reached, for which it should not give up. Joints move as they are told to, without physics.

Example: python scripts/reach_unreachable.py --conditions ur5_pose_home --out runs/unreachable
"""

import argparse
import math
from functools import cache
from itertools import product
from pathlib import Path
from typing import NamedTuple

import numpy as np
import torch
from torch import Tensor

from aicon_baselines.cli.command_line import RESUMABLE, Command, add_option, run_command
from aicon_baselines.evaluation.recording import track
from aicon_baselines.tasks.reach import TASK
from aicon_torch import Policy
from aicon_torch.dampers import PlaceEscape
from aicon_torch.models import make_policy
from aicon_torch.models.reach import Options
from aicon_torch.parts import Chain, TipPose
from aicon_torch.parts.pose_reach import PoseReach
from reach_study import Targets, add_targets, target_seen, targets
from study_table import fill

GIVES_UP = 8
"""After so many places."""

HORIZON = 60.0
FARTHER = (1.1, 2.0)
"""How far a target is from the base, in the longest way that the tip comes from it."""

STARTS, DESCENT = 128, 600
"""The least cost is looked for from so many postures, in so many steps."""

ESCAPE = "a/escape/"


class Row(NamedTuple):
    """What became of a target, one of so many from a first one on."""

    first: int
    targets: int
    condition: str
    reachable: bool
    seed: int
    arrived: bool
    gave_up: float  # s; NaN where it did not
    cost: float  # at the end, m
    least: float  # of all postures within the stops that were found, m
    speed: float  # of the fastest joint in the last second, mean, rad/s


def out_of_reach(found: Targets, seeds: range) -> Targets:
    """The same targets, farther from the base than the tip can come."""
    generator = np.random.default_rng(seeds.start)
    chain = found.robot.chain
    place = found.seen["target_position"]
    farthest = torch.linalg.vector_norm(chain(_postures(chain, 20000))[:, :3, 3], dim=-1).amax()
    wanted = farthest * torch.from_numpy(generator.uniform(*FARTHER, len(place)))
    moved = place * (wanted / torch.linalg.vector_norm(place, dim=-1)).unsqueeze(-1)
    seen = {**found.seen, "target_position": moved}
    return found._replace(seen=seen, places=target_seen(found.pose, seen))


def least_cost(chain: Chain, reach: PoseReach, pose: TipPose, target: Tensor) -> Tensor:
    """The least cost ``(k,)`` of targets ``(k, size)`` within the stops, by Adam."""
    q = _postures(chain, STARTS * len(target)).reshape(STARTS, len(target), -1).requires_grad_()
    optimizer = torch.optim.Adam([q], lr=0.05)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, DESCENT)

    target = target.expand(STARTS, -1, -1)
    margin = Options().joint_limits.margin
    low, high = chain.low + margin, chain.high - margin
    for _ in track(range(DESCENT), "least cost"):
        optimizer.zero_grad()
        reach(pose.of_frame(chain(q)), target).sum().backward()  # type: ignore[no-untyped-call]
        optimizer.step()
        schedule.step()
        with torch.no_grad():
            q.clamp_(low, high)
    return reach(pose.of_frame(chain(q)), target).detach().amin(0)


def _postures(chain: Chain, count: int) -> Tensor:
    """Random postures within the stops, ``(count, n)``."""
    shares = torch.rand(
        count, len(chain.names), generator=torch.Generator().manual_seed(0), dtype=torch.float64
    )
    return chain.low + shares * (chain.high - chain.low)


def follow(policy: Policy, first: int, count: int, condition: str, reachable: bool) -> list[Row]:
    """What becomes of some targets."""
    seeds = range(first, first + count)
    found = targets(condition, seeds)
    if not reachable:
        found = out_of_reach(found, seeds)
    options = Options(**TASK.policy_options(condition))
    pose = TipPose(options.orientation, options.lever, options.axis)
    reach = PoseReach(pose, options.tolerance)
    target = target_seen(pose, found.seen)

    seen, memory = found.seen, None
    gave_up = torch.full((len(seeds),), math.nan, dtype=torch.float64)
    arrived = torch.zeros(len(seeds), dtype=torch.bool)
    speed = torch.zeros(len(seeds), dtype=torch.float64)
    steps, last = round(HORIZON / TASK.time_step), round(1.0 / TASK.time_step)
    for step in track(range(steps), f"{condition}, reachable: {reachable}"):
        action, memory = policy.predict(seen, memory)
        seen = {**seen, "q": seen["q"] + TASK.time_step * action}
        arrived |= found.has(seen["q"])
        new = memory[f"{ESCAPE}gave_up"] & gave_up.isnan()
        gave_up[new] = step * TASK.time_step
        if step >= steps - last:
            speed += action.abs().amax(-1) / last

    cost = reach(pose.of_frame(found.robot.chain(seen["q"])), target)
    least = least_cost(found.robot.chain, reach, pose, target) if not reachable else 0.0 * cost
    columns = (arrived, gave_up, cost, least, speed)
    rows = zip(seeds, *(column.tolist() for column in columns), strict=True)
    return [Row(first, count, condition, reachable, *row) for row in rows]


def run(arguments: argparse.Namespace) -> None:
    """Run what is not yet in the table, and report each condition."""
    torch.set_num_threads(1)

    @cache
    def policy_of(condition: str) -> Policy:
        options = dict(TASK.policy_options(condition))
        options["dampers.escape"] = PlaceEscape(gives_up=GIVES_UP)
        return make_policy("reach", **options).compile()

    def measure(first: int, count: int, condition: str, reachable: bool) -> list[Row]:
        return follow(policy_of(condition), first, count, condition, reachable)

    wanted = list(
        product([arguments.seed], [arguments.episodes], arguments.conditions, (False, True))
    )
    rows = fill(arguments.out / "unreachable.csv", Row, wanted, measure, "conditions")
    for begin in wanted:
        report([row for row in rows if row[: len(begin)] == begin])


def report(rows: list[Row]) -> None:
    """How many gave up, when, and how near they came."""
    gave_up = np.array([row.gave_up for row in rows])
    said = np.isfinite(gave_up)
    told = f"{rows[0].condition}: {'' if rows[0].reachable else 'un'}reachable; "
    told += f"arrived {sum(row.arrived for row in rows)}, gave up {said.sum()} of {len(rows)}"
    if said.any():
        told += f", after {np.median(gave_up[said]):.0f} s (median)"

    if not rows[0].reachable:
        excess = np.array([row.cost / row.least - 1.0 for row in rows])
        near = int((excess < 0.05).sum())
        told += f"; cost within 5 % of the least in {near}, "
        told += f"more by {100 * np.median(excess):.2f} % at the median "
        told += f"and {100 * excess.max():.0f} % at most; "
        told += f"fastest joint at the end {max(row.speed for row in rows):.3f} rad/s at most"
    print(told)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what is run."""
    add_targets(parser, 100)
    add_option(parser, "--out", Path("runs/unreachable"), "folder of the results")


COMMAND = Command(__doc__, add_arguments, run, RESUMABLE)

if __name__ == "__main__":
    run_command(COMMAND)
