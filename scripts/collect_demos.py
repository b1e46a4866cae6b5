"""Record successful episodes of AICON on pushT as a LeRobotDataset, to train a diffusion policy on.

Example: python scripts/collect_demos.py --episodes 200 --out runs/demos
         python scripts/train_diffusion.py --data runs/demos --out runs/diffusion

The same command goes on where a stopped run was. It needs LeRobot: make install.
"""

import argparse
from pathlib import Path

from aicon_baselines.agents.diffusion.configs import OBSERVATIONS, RecordingConfig
from aicon_baselines.cli.command_line import (
    RESUMABLE,
    Command,
    add_fields,
    fields_of,
    run_command,
)

FIELDS = {
    "episodes": "successful episodes",
    "seed": "first seed",
    "noises": "noise on actions, px",
    "near": "share of starts near the goal",
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what is recorded."""
    add_fields(parser, RecordingConfig(), FIELDS)
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

    observed = tuple(arguments.observe)
    config = RecordingConfig(observations=observed, **fields_of(arguments, FIELDS))
    with tqdm(total=config.episodes, unit="episode", disable=None) as bar:

        def on_recorded(count: int) -> None:
            bar.update(count)

        collect(config, arguments.out, on_recorded)

    print(f"{config.episodes} episodes, saved in {arguments.out}; to train a diffusion policy:")
    print(f"python scripts/train_diffusion.py --data {arguments.out} --out runs/diffusion")


COMMAND = Command(__doc__, add_arguments, run, RESUMABLE)

if __name__ == "__main__":
    run_command(COMMAND)
