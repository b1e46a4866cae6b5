"""How the arm pushes: heights, views, limits, conflicts and errors of each episode.

Example: python scripts/arm_push_episodes.py --policies aicon steepest --out runs/arm_push

The same command goes on where a stopped run was. Episodes run in the chunks of a comparison, so
each goes as it goes there.
"""

import argparse
from itertools import product
from pathlib import Path
from typing import Any

from aicon_baselines.cli.command_line import RESUMABLE, Command, run_command

# isort: split

import torch

from aicon_baselines.agents.registry import factory, names
from aicon_baselines.cli.compiling import add_compile_option, compiled_as_asked
from aicon_baselines.evaluation.predictor import Factory
from aicon_baselines.files import only_writer
from aicon_baselines.tasks.arm_push import TASK
from aicon_baselines.tasks.arm_push_numbers import EpisodeNumbers, in_words, load, save
from aicon_baselines.tasks.arm_push_recording import watch


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the policies, conditions and episodes."""
    policies = names("arm_push")
    parser.add_argument(
        "--policies",
        nargs="+",
        default=["aicon"],
        choices=policies,
        metavar="NAME",
        help=", ".join(policies),
    )
    parser.add_argument(
        "--conditions",
        nargs="+",
        default=["camera"],
        choices=TASK.conditions,
        metavar="NAME",
        help=", ".join(TASK.conditions),
    )
    add_compile_option(parser)
    parser.add_argument("--episodes", type=int, default=10, help="seeds (default: 10)")
    parser.add_argument("--seed", type=int, default=0, help="first seed (default: 0)")
    parser.add_argument(
        "--horizon", type=int, default=TASK.horizon, metavar="STEPS", help="limit of an episode"
    )
    parser.add_argument("--out", type=Path, required=True, help="folder of the tables")


def run(arguments: argparse.Namespace) -> None:
    """Run the episodes that are missing, save and print the numbers of all."""
    torch.set_num_threads(1)

    builds = {name: factory("arm_push", name) for name in arguments.policies}
    builds = compiled_as_asked(builds, arguments.compile)

    with only_writer(arguments.out):
        for condition, policy in product(arguments.conditions, arguments.policies):
            path = arguments.out / f"{condition}_{policy}.csv"
            numbers = take_numbers(builds[policy], condition, path, arguments)
            print(f"{condition}, {policy}: {in_words(numbers)}", flush=True)


def take_numbers(
    build: Factory, condition: str, path: Path, arguments: argparse.Namespace
) -> list[EpisodeNumbers]:
    """Return the numbers of all episodes; those not in the table yet are run, chunk by chunk."""
    seeds = range(arguments.seed, arguments.seed + arguments.episodes)
    rows = {row.seed: row for row in load(path)}

    def keep(numbers: EpisodeNumbers) -> None:
        rows[numbers.seed] = numbers
        save(rows.values(), path)

    policy: Any = None
    for index in range(seeds[0] // TASK.chunk_size, seeds[-1] // TASK.chunk_size + 1):
        chunk = TASK.chunk(index, repeat=0)
        missing = {episode.seed for episode in chunk} & (set(seeds) - set(rows))

        if missing:
            policy = policy or build(condition)
            watch(policy, condition, chunk, arguments.horizon, keep, missing)
    return [rows[seed] for seed in seeds]


COMMAND = Command(__doc__, add_arguments, run, RESUMABLE)

if __name__ == "__main__":
    run_command(COMMAND)
