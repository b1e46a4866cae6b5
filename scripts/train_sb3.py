"""Train an agent of stable-baselines3 on a task, to be compared by compare.py.

Example: python scripts/train_sb3.py --task pusht --algorithm ppo --steps 1000000 --out runs/ppo_pusht
         python scripts/compare.py --task pusht --policies aicon sb3 --sb3-path runs/ppo_pusht --out runs/pusht

The same command goes on where a stopped run saved the agent last; with more steps it goes on with a finished one.
Reward, actions, observations and the folder are described in aicon_baselines/sb3/.
"""

import argparse
import os
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")  # read when torch is loaded: the networks are small

from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.agents.registry import import_sb3


def main() -> None:
    """Parse the arguments, train what is missing and say what to do with it."""
    parser = _parser()
    arguments = parser.parse_args()
    try:
        sb3 = import_sb3()
        names = ("seed", "envs", "rollout", "epochs", "horizon", "stack", "approach")
        options = {name: getattr(arguments, name) for name in names}
        config = sb3.settings(arguments.task, arguments.algorithm, arguments.steps, **options)
        trained = sb3.train(config, arguments.out, arguments.checkpoint, report=print)
    except ComparisonError as error:
        parser.error(str(error))
    except KeyboardInterrupt:
        parser.exit(130, "\nstopped; the same command goes on from the last checkpoint\n")
    print(f"{trained.steps:,} steps, saved in {arguments.out}; to compare it:")
    print(
        f"python scripts/compare.py --task {config.task} --policies aicon sb3 --sb3-path {arguments.out} "
        f"--out runs/{config.task}"
    )


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--task", required=True, help="name of the task, nav2d or pusht")
    parser.add_argument("--algorithm", default="ppo", help="ppo or sac (default: ppo)")
    parser.add_argument("--steps", type=int, default=1_000_000, help="steps in all (default: 1000000)")
    parser.add_argument("--out", type=Path, required=True, help="folder of the agent")
    parser.add_argument("--seed", type=int, default=10_000, help="seed, 1000 or more (default: 10000)")
    parser.add_argument("--checkpoint", type=int, default=50_000, help="steps between saves (default: 50000)")
    parser.add_argument("--envs", type=int, help="environments (default: 8)")
    parser.add_argument("--rollout", type=int, help="steps of each environment between updates of PPO (default: 512)")
    parser.add_argument("--epochs", type=int, help="times PPO learns from them (default: 5 in nav2d, 10 in pusht)")
    parser.add_argument(
        "--horizon", type=int, help="steps of a training episode (default: 1000 in nav2d, 300 in pusht)"
    )
    parser.add_argument("--stack", type=int, help="observations seen at once (default: 8 in nav2d, 1 in pusht)")
    parser.add_argument("--approach", type=float, help="pusht: weight of the way to the object (default: 0.2)")
    return parser


if __name__ == "__main__":
    main()
