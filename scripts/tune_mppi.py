"""Search for the options of MPPI on pushT, on seeds that are not reported.

Example: python scripts/tune_mppi.py mppi mppi,noise=0.1 mppi,horizon=20 --out runs/mppi

Each candidate is a preset with other values of some options. The same command goes on where a
stopped run was, and other candidates are added to the same folder.
"""

import argparse
from dataclasses import replace
from math import gcd
from pathlib import Path

from aicon_baselines.agents.registry import compiled, factory
from aicon_baselines.agents.variants import parse_variant
from aicon_baselines.cli.command_line import RESUMABLE, Command, run_command
from aicon_baselines.evaluation.comparison import compare
from aicon_baselines.evaluation.config import configure
from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.evaluation.report import write_report
from aicon_baselines.evaluation.run_folder import RunFolder
from aicon_baselines.tasks import load

FIRST_SEED = 1000
"""Seeds below this are for reporting."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the candidates and the episodes."""
    parser.add_argument("candidates", nargs="+", metavar="TEXT", help="such as mppi,samples=64")
    parser.add_argument("--condition", default="deterministic", help="default: deterministic")
    parser.add_argument("--seed", type=int, default=1000, help=f"first, {FIRST_SEED} or more")
    parser.add_argument("--episodes", type=int, default=16, help="seeds (default: 16)")
    parser.add_argument("--horizon", type=int, default=300, help="limit, steps (default: 300)")
    parser.add_argument("--out", type=Path, required=True, help="folder of the results")


def run(arguments: argparse.Namespace) -> None:
    """Run what is missing in the folder and print the table of results."""
    if arguments.seed < FIRST_SEED:
        raise ComparisonError(
            f"--seed {arguments.seed}: seeds below {FIRST_SEED} are for reporting, not for tuning"
        )

    # Batches that hold no other episodes: planning takes as long for those.
    size = gcd(arguments.seed, arguments.episodes)
    task = replace(load("pusht"), chunk_size=size)
    config = configure(
        task,
        seed=arguments.seed,
        episodes=arguments.episodes,
        conditions=[arguments.condition],
        horizon=arguments.horizon,
    )

    candidates = {}
    for text in arguments.candidates:
        name, options = parse_variant(text)
        candidates[text] = compiled(factory(task.name, name, **options))

    with RunFolder.open(arguments.out, config) as folder:
        compare(task, candidates, folder)
        table = write_report(task, folder)
    print(table)


COMMAND = Command(__doc__, add_arguments, run, RESUMABLE)

if __name__ == "__main__":
    run_command(COMMAND)
