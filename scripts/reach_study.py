"""Reaching without physics: joints move as they are told to, hundreds of targets side by side.

What the escape of an arm is worth is found out here in seconds, on the targets of the environment
at the same seeds; what counts is the environment (`aicon compare --task reach`).

Example: python scripts/reach_study.py --conditions ur5_pose_home --out runs/reach_study
"""

import argparse
import math
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import torch
from torch import Tensor

from aicon_baselines.cli.command_line import RESUMABLE, Command, add_option, at_least, run_command
from aicon_baselines.evaluation.intervals import wilson_interval
from aicon_baselines.evaluation.recording import track
from aicon_baselines.tasks.reach import TASK
from aicon_torch import Policy
from aicon_torch.models import make_policy
from aicon_torch.models.reach import Options
from aicon_torch.parts import Robot, TipPose
from aicon_torch.parts.self_collision import CapsuleSegments, SelfCollision
from clutter import NEAR, STRAIGHT
from study_table import fill


class Row(NamedTuple):
    """What became of a target, one of so many from a first one on."""

    first: int
    targets: int
    outside: float  # rad
    condition: str
    seed: int
    time: float  # s; NaN where it did not arrive
    detours: int
    inside: float  # s, from when on no joint is beyond its stop


class Targets(NamedTuple):
    """The targets of a condition.

    Attributes:
        robot: Who reaches.
        pose: What of its tip counts.
        seen: The first observations of the environment, ``(seeds, size)`` each.
        places: The targets as poses, ``(seeds, size)``.
    """

    robot: Robot
    pose: TipPose
    seen: dict[str, Tensor]
    places: Tensor

    def has(self, q: Tensor) -> Tensor:
        """Whether the tip is at its target in postures ``(seeds, n)``, ``(seeds,)``."""
        missing, angle = self.pose.distance(self.pose.of_frame(self.robot.chain(q)), self.places)
        return (missing < NEAR) & (angle < STRAIGHT)


def targets(condition: str, seeds: Sequence[int]) -> Targets:
    """The targets of the environment at some seeds."""
    env = TASK.make_env(1, condition, TASK.horizon)
    first = [env.reset(seed=seed)[0] for seed in track(seeds, f"{condition}, targets")]
    env.close()
    rows = {name: np.concatenate([one[name] for one in first]) for name in first[0]}
    seen = {name: torch.from_numpy(values) for name, values in rows.items()}

    options = TASK.policy_options(condition)
    robot = Robot.from_urdf(options["robot"], tip=options["tip"], srdf=options["srdf"])
    pose = TipPose(options["orientation"], lever=1.0)
    return Targets(robot, pose, seen, target_seen(pose, seen))


def target_seen(pose: TipPose, seen: Mapping[str, Tensor]) -> Tensor:
    """The target of observations as a pose, ``(*B, size)``."""
    place, turn = seen["target_position"], seen.get("target_orientation")
    return place if turn is None else pose.target(place, turn)


def room(robot: Robot, q: Tensor) -> Tensor:
    """How far the robot's capsules are apart at least, ``(*B,)``, m, in postures ``(*B, n)``."""
    assert robot.shape is not None
    segments = CapsuleSegments(robot.chain, robot.shape.capsules)
    itself = SelfCollision(robot.shape.capsules, Options().self_collision, robot.shape.pairs)
    return itself.distances(segments(q)).amin(-1)


def beyond_a_stop(robot: Robot, q: Tensor, by: float) -> Tensor:
    """Postures ``(seeds, n)`` of which one joint is beyond the stop that is nearer to it, rad.

    It is the first one, from another on in each, with which the robot is clear of itself.
    """
    count = q.shape[-1]
    is_low = q - robot.chain.low < robot.chain.high - q
    outside = torch.where(is_low, robot.chain.low - by, robot.chain.high + by)

    found, is_done = q.clone(), torch.zeros(len(q), dtype=torch.bool)
    for further in range(count):
        which = (torch.arange(len(q)) + further) % count
        chosen = torch.nn.functional.one_hot(which, count).bool()
        moved = torch.where(chosen & outside.isfinite(), outside, q)

        is_clear = (room(robot, moved) > Options().self_collision.margin) & (moved != q).any(-1)
        found = torch.where((is_clear & ~is_done).unsqueeze(-1), moved, found)
        is_done = is_done | is_clear
    return found


def reach(policy: Policy, first: int, count: int, outside: float, condition: str) -> list[Row]:
    """What becomes of the targets of a condition within the horizon of the task."""
    seeds = range(first, first + count)
    found = targets(condition, seeds)
    chain, seen = found.robot.chain, found.seen
    if outside:
        seen["q"] = beyond_a_stop(found.robot, seen["q"], outside)
    memory: Any = None
    times = torch.full((len(seeds),), math.nan, dtype=torch.float64)
    detours = torch.zeros(len(seeds), dtype=torch.long)
    inside = torch.zeros(len(seeds), dtype=torch.float64)
    for step in track(range(TASK.horizon + 1), condition):
        going = times.isnan()
        is_outside = ((seen["q"] < chain.low) | (seen["q"] > chain.high)).any(-1)
        inside[going & is_outside] = (step + 1) * TASK.time_step
        times[going & found.has(seen["q"])] = step * TASK.time_step
        if not times.isnan().any():
            break

        action, memory = policy.predict(seen, memory)
        seen = seen | {"q": seen["q"] + TASK.time_step * action}
        detours = torch.where(times.isnan(), memory.get("a/escape/escapes", detours), detours)
    columns = (times.tolist(), detours.tolist(), inside.tolist())
    rows = zip(seeds, *columns, strict=True)
    return [Row(first, count, outside, condition, *row) for row in rows]


def run(arguments: argparse.Namespace) -> None:
    """Run what is not yet in the table, and report each condition."""
    torch.set_num_threads(1)

    @cache
    def policy_of(condition: str) -> Policy:
        options = TASK.policy_options(condition)
        return make_policy("reach", preset=arguments.preset, **options).compile()

    def measure(first: int, count: int, outside: float, condition: str) -> list[Row]:
        return reach(policy_of(condition), first, count, outside, condition)

    settings = (arguments.seed, arguments.episodes, arguments.outside)
    wanted = [(*settings, condition) for condition in arguments.conditions]
    rows = fill(arguments.out / f"{arguments.preset}.csv", Row, wanted, measure, "conditions")
    for condition in arguments.conditions:
        report(condition, [row for row in rows if row.condition == condition])


def report(condition: str, rows: list[Row]) -> None:
    """How many arrived (95 %, Wilson), how soon, and which did not."""
    times = np.array([row.time for row in rows])
    arrived = np.isfinite(times)
    low, high = wilson_interval(int(arrived.sum()), len(rows))
    failed = [str(row.seed) for row in rows if math.isnan(row.time)]
    print(
        f"{condition}: {arrived.sum()} of {len(rows)} ({100 * low:.1f} to {100 * high:.1f}), "
        f"median {np.median(times[arrived]):.1f} s; all joints within their stops from "
        f"{max(row.inside for row in rows):.2f} s on; failed: {', '.join(failed) or 'none'}"
    )


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what is run."""
    add_targets(parser, 200)
    parser.add_argument("--preset", choices=TASK.presets, default="aicon")
    add_option(parser, "--outside", 0.0, "how far beyond its stop a joint starts, rad")
    add_option(parser, "--out", Path("runs/reach_study"), "folder of the results")


def add_targets(parser: argparse.ArgumentParser, count: int) -> None:
    """Declare which targets, and so many as usual."""
    parser.add_argument(
        "--conditions", nargs="+", choices=TASK.conditions, required=True, metavar="NAME"
    )
    add_option(parser, "--episodes", count, "targets of each condition", type=at_least(1))
    add_option(parser, "--seed", 1000, "of the first target", type=at_least(0))


COMMAND = Command(__doc__, add_arguments, run, RESUMABLE)

if __name__ == "__main__":
    run_command(COMMAND)
