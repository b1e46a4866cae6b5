"""Search over gain and speed, the same for every policy, on seeds that are not reported.

Example: python scripts/tune.py --policies aicon paper_literal steepest potential_field --jobs 2 --out runs/tune

The best of each policy is what its preset should hold. The same command goes on where a stopped run was.
"""

import argparse
import os
from functools import partial
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING

os.environ.setdefault("OMP_NUM_THREADS", "1")  # read when torch is loaded, here and in the workers

from aicon_baselines.compare import compare
from aicon_baselines.config import configure
from aicon_baselines.report import write_report
from aicon_baselines.runs import RunFolder
from aicon_baselines.tasks import load

if TYPE_CHECKING:
    from aicon_torch import Policy


GAINS = (0.3, 0.6, 1.25, 2.5, 5.0, 10.0, 20.0, 40.0, 80.0, 160.0, 320.0, 640.0)
LAWS: dict[str, dict[str, bool]] = {"preset": {}, "set": {"accumulate": False}, "accumulate": {"accumulate": True}}


def main() -> None:
    """Parse the arguments, run what is missing, save and print the results, best first."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--policies", nargs="+", required=True, metavar="PRESET", help="presets of nav2d")
    parser.add_argument("--gains", nargs="+", type=float, default=GAINS, help="gains of the action law")
    parser.add_argument("--speeds", nargs="+", type=float, default=[0.25, 0.5], help="largest speeds, m/s")
    parser.add_argument("--laws", nargs="+", choices=LAWS, default=["preset"], help="set or accumulate the velocity")
    parser.add_argument("--seed", type=int, default=1024, help="first seed, 1000 or more (default: 1024)")
    parser.add_argument("--episodes", type=int, default=128, help="seeds (default: 128)")
    parser.add_argument("--jobs", type=int, default=1, help="processes (default: 1)")
    parser.add_argument("--out", type=Path, required=True, help="folder of the results")
    arguments = parser.parse_args()
    if arguments.seed < 1000:
        parser.error(f"--seed {arguments.seed}: seeds below 1000 are for reporting, not for tuning")
    task = load("nav2d")
    candidates = {
        f"{preset} {law} gain={gain:g} speed={speed:g}": partial(_build, preset, law, gain, speed)
        for preset, law, gain, speed in product(arguments.policies, arguments.laws, arguments.gains, arguments.speeds)
    }
    folder = RunFolder(arguments.out, configure(task, seed=arguments.seed, episodes=arguments.episodes))
    compare(task, candidates, folder, arguments.jobs)
    print(write_report(folder))


def _build(preset: str, law: str, gain: float, speed: float, condition: str | None) -> "Policy":
    from aicon_torch import make_policy  # in the worker

    sensing = condition or "range"
    return make_policy("nav2d", preset=preset, gain=gain, max_speed=speed, sensing=sensing, **LAWS[law])


if __name__ == "__main__":
    main()
