"""Record successful episodes of AICON on pushT as a LeRobotDataset, to train a diffusion policy on.

Example: python scripts/collect_demos.py --episodes 200 --out runs/demos
         python scripts/train_diffusion.py --data runs/demos --out runs/diffusion

The same command goes on where a stopped run was. It needs LeRobot: make install.
"""

import argparse
from pathlib import Path

from aicon_baselines.agents.diffusion.configs import OBSERVATIONS, RecordingConfig
from aicon_baselines.cli.command_line import RESUMABLE, Command, run_command


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what is recorded."""
    parser.add_argument(
        "--episodes", type=int, default=200, help="successful episodes (default: 200)"
    )
    parser.add_argument("--seed", type=int, default=100_000, help="first seed (default: 100000)")
    parser.add_argument(
        "--noises",
        nargs="+",
        type=float,
        default=[0.0, 2.0],
        metavar="PX",
        help="noise on actions (default: 0 2)",
    )
    parser.add_argument(
        "--near", type=float, default=0.0, help="share of starts near the goal (default: 0)"
    )
    parser.add_argument(
        "--max-speed", type=float, default=250.0, help="the teacher's, px/s (default: 250)"
    )
    parser.add_argument(
        "--smoothing", type=float, default=0.3, help="of its velocity, s (default: 0.3)"
    )
    parser.add_argument(
        "--observe",
        nargs="+",
        choices=OBSERVATIONS,
        default=["keypoints"],
        help="default: keypoints",
    )
    parser.add_argument("--out", type=Path, required=True, help="folder of the dataset")


def run(arguments: argparse.Namespace) -> None:
    """Record what is missing and say what to do with it."""
    # Imported late: it loads torch, which reads the number of threads.
    from tqdm import tqdm

    from aicon_baselines.agents.diffusion.collection import collect

    config = RecordingConfig(
        episodes=arguments.episodes,
        seed=arguments.seed,
        noises=tuple(arguments.noises),
        near=arguments.near,
        max_speed=arguments.max_speed,
        smoothing=arguments.smoothing,
        observations=tuple(arguments.observe),
    )
    with tqdm(total=config.episodes, unit="episode", disable=None) as bar:
        collect(config, arguments.out, bar.update)

    print(f"{config.episodes} episodes, saved in {arguments.out}; to train a diffusion policy:")
    print(f"python scripts/train_diffusion.py --data {arguments.out} --out runs/diffusion")


COMMAND = Command(__doc__, add_arguments, run, RESUMABLE)

if __name__ == "__main__":
    run_command(COMMAND)
