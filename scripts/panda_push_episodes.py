"""How the arm pushes: heights, views, limits, conflicts and errors of each episode, for presets and conditions.

The same command goes on where a stopped run was. In chunks of ten the episodes take the way they take in compare.py.

Example: python scripts/panda_episodes.py --policies aicon no_trace --conditions camera --episodes 10 --out runs/panda
"""

import argparse
import os
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")  # read when torch is loaded

import torch

from aicon_baselines.tasks.panda_push import TASK
from aicon_baselines.tasks.panda_push_numbers import EpisodeNumbers, in_words, load, save, watch
from aicon_torch import make_policy, presets


def main() -> None:
    """Parse the arguments, run the episodes, save and print their numbers."""
    arguments = _parser().parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    torch.set_num_threads(1)
    for condition in arguments.conditions:
        for name in arguments.policies:
            path = arguments.out / f"{condition}_{name}.csv"
            numbers = run(name, condition, range(arguments.seed, arguments.seed + arguments.episodes), arguments, path)
            print(f"{condition}, {name}: {in_words(numbers)}", flush=True)


def run(name: str, condition: str, seeds: range, arguments: argparse.Namespace, path: Path) -> list[EpisodeNumbers]:
    """Take the numbers of the episodes that are not in the table yet, chunk by chunk as a comparison does."""
    rows = {row.seed: row for row in load(path)}

    def finished(numbers: EpisodeNumbers) -> None:
        rows[numbers.seed] = numbers
        save(rows.values(), path)

    policy = None
    for index in range(seeds[0] // TASK.chunk_size, seeds[-1] // TASK.chunk_size + 1):
        chunk = TASK.chunk(index, 0)
        missing = [episode.seed for episode in chunk if episode.seed in seeds and episode.seed not in rows]
        if missing:
            if policy is None:
                policy = make_policy("panda_push", preset=name, **TASK.policy_options(condition))
                policy = policy.compile() if arguments.compile else policy
            watch(policy, condition, chunk, arguments.horizon, finished, missing)
    return [rows[seed] for seed in seeds]


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
    parser.add_argument("--compile", action="store_true", help="compile their steps")
    parser.add_argument("--episodes", type=int, default=10, help="seeds (default: 10)")
    parser.add_argument("--seed", type=int, default=0, help="first seed (default: 0)")
    parser.add_argument("--horizon", type=int, default=18_000, metavar="STEPS", help="limit of an episode")
    parser.add_argument("--out", type=Path, required=True, help="folder of the tables")
    return parser


if __name__ == "__main__":
    main()
