"""How the arm pushes: heights, views, limits, conflicts and errors of each episode, for presets and conditions.

Example: python scripts/panda_episodes.py --policies aicon no_trace --conditions camera --episodes 10 --out runs/panda
"""

import argparse
import os
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")  # read when torch is loaded

from aicon_baselines.panda import TASK
from aicon_baselines.panda_episodes import EpisodeNumbers, in_words, save, watch
from aicon_torch import make_policy, presets


def main() -> None:
    """Parse the arguments, run the episodes, save and print their numbers."""
    arguments = _parser().parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    seeds = range(arguments.seed, arguments.seed + arguments.episodes)
    for condition in arguments.conditions:
        for name in arguments.policies:
            path = arguments.out / f"{condition}_{name}.csv"
            done: list[EpisodeNumbers] = []

            def finished(numbers: EpisodeNumbers, path: Path = path, done: list[EpisodeNumbers] = done) -> None:
                done.append(numbers)
                save(done, path)

            policy = make_policy("panda_push", preset=name, **TASK.policy_options(condition))
            watch(policy, condition, seeds, arguments.horizon, finished)
            print(f"{condition}, {name}: {in_words(done)}", flush=True)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    names = presets("panda_push")
    parser.add_argument(
        "--policies", nargs="+", default=["aicon"], choices=names, metavar="NAME", help=", ".join(names)
    )
    conditions = TASK.conditions
    parser.add_argument(
        "--conditions", nargs="+", default=["camera"], choices=conditions, metavar="NAME", help=", ".join(conditions)
    )
    parser.add_argument("--episodes", type=int, default=10, help="seeds, run together (default: 10)")
    parser.add_argument("--seed", type=int, default=0, help="first seed (default: 0)")
    parser.add_argument("--horizon", type=int, default=18_000, metavar="STEPS", help="limit of an episode")
    parser.add_argument("--out", type=Path, required=True, help="folder of the tables")
    return parser


if __name__ == "__main__":
    main()
