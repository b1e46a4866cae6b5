"""Vary the options of a policy and compare each variant with the policy itself, pair by pair.

Example: python scripts/study.py --task pusht --episodes 500 --out runs/study \
           --variants without_softmax resolution.temperature=None law.step=0.5,max_speed=0.4

A variant is a policy of the task, or options of the policy "aicon", or a policy and options;
options are named as in `make_policy`. The same command goes on where a stopped run was; another one
with other variants adds them to the same folder.
"""

import argparse
from pathlib import Path

from aicon_baselines.agents.variants import make_variants
from aicon_baselines.cli.command_line import RESUMABLE, Command, add_option, at_least, run_command
from aicon_baselines.cli.compiling import add_compile_option, compiled_as_asked
from aicon_baselines.evaluation.comparison import compare
from aicon_baselines.evaluation.config import configure
from aicon_baselines.evaluation.run_folder import RunFolder
from aicon_baselines.evaluation.study import write_study
from aicon_baselines.tasks import load


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the variants and the episodes."""
    parser.add_argument("--task", required=True, help="name of the task")
    parser.add_argument(
        "--variants",
        nargs="+",
        required=True,
        metavar="TEXT",
        help="policy, option=value,... or both",
    )
    add_option(parser, "--episodes", 100, "seeds")
    add_option(parser, "--seed", 1000, "first seed", type=at_least(0))
    parser.add_argument(
        "--condition", metavar="NAME", help="variant of the environment (default: the first)"
    )
    parser.add_argument(
        "--horizon",
        type=int,
        metavar="STEPS",
        help="limit of an episode (default: the task's)",
    )
    add_compile_option(parser)
    parser.add_argument("--out", type=Path, required=True, help="folder of the results")
    add_option(parser, "--jobs", 1, "processes")


def run(arguments: argparse.Namespace) -> None:
    """Run what is missing in the folder and print the table of results."""
    task = load(arguments.task)
    condition = arguments.condition or task.conditions[0]
    config = configure(
        task,
        seed=arguments.seed,
        episodes=arguments.episodes,
        conditions=[condition],
        horizon=arguments.horizon,
    )
    policies = make_variants(task, condition, arguments.variants)
    policies = compiled_as_asked(policies, arguments.compile)

    with RunFolder.open(arguments.out, config) as folder:
        compare(task, policies, folder, arguments.jobs)
        table = write_study(task, folder, list(policies))

    print(table)
    print(f"\nsaved in {arguments.out}: episodes.csv, study.json, study.png")


COMMAND = Command(__doc__, add_arguments, run, RESUMABLE)

if __name__ == "__main__":
    run_command(COMMAND)
