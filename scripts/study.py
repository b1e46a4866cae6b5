"""Vary the options of a policy and compare each variant with the policy itself, on the same episodes.

Example: python scripts/study.py --task pusht --episodes 500 --variants no_softmax ratio=2.1,margin=0.07 --out runs/x

A variant is a preset, or options of the preset "aicon", or a preset and options. The same command goes on where a
stopped run was; another one with other variants adds them to the same folder.
"""

import argparse
import os
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")  # read when torch is loaded, here and in the workers

from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.evaluation.comparison import compare
from aicon_baselines.evaluation.config import configure
from aicon_baselines.evaluation.run_folder import RunFolder
from aicon_baselines.evaluation.study import write_study
from aicon_baselines.tasks import load
from aicon_baselines.evaluation.variants import make_variants


def main() -> None:
    """Parse the arguments, run what is missing, save and print the results."""
    parser = _parser()
    arguments = parser.parse_args()
    try:
        table = _run(arguments)
    except ComparisonError as error:
        parser.error(str(error))
    except KeyboardInterrupt:
        parser.exit(130, "\nstopped; the same command goes on from here\n")
    print(table)
    print(f"\nsaved in {arguments.out}: episodes.csv, study.json, study.png")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--task", required=True, help="name of the task, nav2d or pusht")
    parser.add_argument("--variants", nargs="+", required=True, metavar="TEXT", help="preset, option=value,… or both")
    parser.add_argument("--episodes", type=int, default=100, help="seeds (default: 100)")
    parser.add_argument("--seed", type=int, default=1000, help="first seed (default: 1000)")
    parser.add_argument("--condition", metavar="NAME", help="variant of the task (default: the first)")
    parser.add_argument("--horizon", type=int, metavar="STEPS", help="limit of an episode (default: the task's)")
    parser.add_argument("--out", type=Path, required=True, help="folder of the results")
    parser.add_argument("--jobs", type=int, default=1, help="processes (default: 1)")
    return parser


def _run(arguments: argparse.Namespace) -> str:
    """Run what is missing in the folder and return the table of results."""
    task = load(arguments.task)
    conditions = [arguments.condition or task.conditions[0]]
    config = configure(
        task, seed=arguments.seed, episodes=arguments.episodes, conditions=conditions, horizon=arguments.horizon
    )
    policies = make_variants(task, conditions[0], arguments.variants)
    folder = RunFolder(arguments.out, config)
    compare(task, policies, folder, arguments.jobs)
    return write_study(task, folder, list(policies))


if __name__ == "__main__":
    main()
