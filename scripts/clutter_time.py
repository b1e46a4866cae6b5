"""How the time of a step in C, and of its compilation, grow with the number of objects.

Example: python scripts/clutter_time.py panda --out runs/clutter_time

The objects are those of a problem, and beyond them boxes at random places about the robot.
"""

import argparse
import tempfile
from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import NamedTuple

import numpy as np
import torch

from aicon_baselines.cli.command_line import RESUMABLE, Command, add_option, at_least, run_command
from aicon_baselines.evaluation.tables import to_markdown
from aicon_baselines.evaluation.timing import processor_seconds
from aicon_baselines.worlds.motion_bench_maker import (
    ROBOTS,
    Problem,
    problems,
    resources,
    robot_of,
)
from aicon_torch import load_exported
from aicon_torch.parts import Robot, Solid
from clutter import CACHE, POLICIES, World, policy_of, time_of_a_step
from study_table import fill, read

COUNTS = (5, 10, 21, 50, 100, 200)

AWAY = 0.05
"""How far from the robot an object is at least, m."""

FARTHEST = 1.2
"""From the robot's base to the middle of an object, at most, m."""

SIZES = (0.02, 0.10)
"""Between which the lengths of a random box are, m."""


class Row(NamedTuple):
    """What one number of objects takes; a policy reads so many, and there are so many."""

    robot: str
    policy: str
    objects: int
    distances: int  # of the robot's spheres to objects
    step: float  # of the processor, µs
    compilation: float  # of the processor, with the compiler's, s
    size: int  # of the machine code, bytes


def run(arguments: argparse.Namespace) -> None:
    """Measure what is not yet in the table, and report."""
    torch.set_num_threads(1)
    folder = resources(CACHE)
    robot = robot_of(arguments.robot, folder)
    given = problems(arguments.robot, folder, robot.chain.names, ROBOTS[arguments.robot].sets, [1])
    crowded = max(given, key=lambda problem: len(problem.solids))

    def measure(robot_name: str, name: str, count: int) -> list[Row]:
        problem = replace(crowded, solids=some_objects(robot, crowded, count))
        return [measured(robot, problem, name)]

    table = arguments.out / f"{arguments.robot}.csv"
    wanted = list(product([arguments.robot], arguments.agents, arguments.counts))
    fill(table, Row, wanted, measure, "objects")
    report(read(table, Row))


def measured(robot: Robot, problem: Problem, name: str) -> Row:
    """A policy among the objects of a problem, exported and timed."""
    count = len(problem.solids)
    policy = policy_of(problem.robot, robot, name, count)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "policy.so")
        before = processor_seconds()
        policy.export(path)
        compilation = processor_seconds() - before
        step = time_of_a_step(load_exported(path), robot, problem, count)
        size = path.stat().st_size

    assert robot.shape is not None
    moving = sum(capsule.link > 0 for capsule in robot.shape.capsules)
    return Row(problem.robot, name, count, moving * count, step, compilation, size)


def some_objects(robot: Robot, problem: Problem, count: int) -> tuple[Solid, ...]:
    """So many objects: those of a problem, and boxes that are free of the robot at its start."""
    generator = np.random.default_rng(0)
    found = list(problem.solids[:count])
    while len(found) < count:
        sides = tuple(generator.uniform(*SIZES, 3).tolist())
        middle = tuple(generator.uniform(-FARTHEST, FARTHEST, 3).tolist())
        box = Solid("box", sides, middle, tuple(generator.normal(size=4).tolist()))
        world = World(robot, replace(problem, solids=(box,)))
        gap, _ = world.gaps(problem.start[None])
        if gap[0] > AWAY and np.linalg.norm(middle) < FARTHEST:
            found.append(box)
    return tuple(found)


def report(rows: Sequence[Row]) -> None:
    """Print a table."""
    header = ["policy", "objects", "distances", "a step, µs", "compilation, s", "machine code, kB"]
    lines = []
    for row in sorted(rows, key=lambda row: (row.policy, row.objects)):
        numbers = (row.step, row.compilation, row.size / 1e3)
        lines.append([row.policy, str(row.objects), str(row.distances)])
        lines[-1] += [f"{number:.0f}" for number in numbers]
    print(to_markdown(header, lines))


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what is measured."""
    parser.add_argument("robot", choices=ROBOTS, help="whose problem")
    parser.add_argument("--agents", nargs="+", choices=POLICIES, default=["aicon"])
    add_option(parser, "--counts", COUNTS, "of objects", type=at_least(1))
    add_option(parser, "--out", Path("runs/clutter_time"), "folder of the results")


COMMAND = Command(__doc__, add_arguments, run, RESUMABLE)

if __name__ == "__main__":
    run_command(COMMAND)
