"""Search over gain and speed, the same for every policy of a task, on seeds that are not reported.

Example: python scripts/tune.py --policies aicon paper_literal steepest potential_field --jobs 2 --out runs/tune

The best of each policy is what its preset should hold. The same command goes on where a stopped run was.
"""

import argparse
import os
from itertools import product
from pathlib import Path
from typing import NamedTuple

os.environ.setdefault("OMP_NUM_THREADS", "1")  # read when torch is loaded, here and in the workers

from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.evaluation.comparison import compare
from aicon_baselines.evaluation.config import configure
from aicon_baselines.agents.registry import factory
from aicon_baselines.evaluation.report import write_report
from aicon_baselines.evaluation.run_folder import RunFolder
from aicon_baselines.tasks import load


class Search(NamedTuple):
    """What is searched unless asked otherwise, on which seeds; speeds in the task's unit of length per second."""

    gains: tuple[float, ...]
    speeds: tuple[float, ...]
    seed: int
    episodes: int


SEARCHES = {
    "nav2d": Search((0.3, 0.6, 1.25, 2.5, 5.0, 10.0, 20.0, 40.0, 80.0, 160.0, 320.0, 640.0), (0.25, 0.5), 1024, 128),
    "pusht": Search((4e3, 16e3, 64e3, 256e3, 1e6, 1e9), (100.0, 200.0, 400.0, 800.0), 1000, 100),
}
LAWS: dict[str, dict[str, bool]] = {"preset": {}, "set": {"accumulate": False}, "accumulate": {"accumulate": True}}


def main() -> None:
    """Parse the arguments, run what is missing, save and print the results, best first."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--task", choices=SEARCHES, default="nav2d", help="the task (default: nav2d)")
    parser.add_argument("--policies", nargs="+", required=True, metavar="PRESET", help="presets of the task's model")
    parser.add_argument("--gains", nargs="+", type=float, help="gains of the action law (default: the task's)")
    parser.add_argument("--speeds", nargs="+", type=float, help="largest speeds, m/s or px/s (default: the task's)")
    parser.add_argument("--laws", nargs="+", choices=LAWS, default=["preset"], help="set or accumulate the velocity")
    parser.add_argument("--seed", type=int, help="first seed, 1000 or more (default: the task's)")
    parser.add_argument("--episodes", type=int, help="seeds (default: the task's)")
    parser.add_argument("--jobs", type=int, default=1, help="processes (default: 1)")
    parser.add_argument("--out", type=Path, required=True, help="folder of the results")
    parser.set_defaults(**SEARCHES[parser.parse_known_args()[0].task]._asdict())
    arguments = parser.parse_args()
    if arguments.seed < 1000:
        parser.error(f"--seed {arguments.seed}: seeds below 1000 are for reporting, not for tuning")
    try:
        print(_run(arguments))
    except ComparisonError as error:
        parser.error(str(error))


def _run(arguments: argparse.Namespace) -> str:
    """Run what is missing in the folder and return the table of results."""
    task = load(arguments.task)
    candidates = {
        f"{preset} {law} gain={gain:g} speed={speed:g}": factory(
            task.name, preset, gain=gain, max_speed=speed, **LAWS[law]
        )
        for preset, law, gain, speed in product(arguments.policies, arguments.laws, arguments.gains, arguments.speeds)
    }
    folder = RunFolder(arguments.out, configure(task, seed=arguments.seed, episodes=arguments.episodes))
    compare(task, candidates, folder, arguments.jobs)
    return write_report(task, folder)


if __name__ == "__main__":
    main()
