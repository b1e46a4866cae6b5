"""Train an agent of stable-baselines3 on a task, to be compared by `aicon compare`.

Example: python scripts/train_sb3.py --task pusht --algorithm ppo --out runs/ppo_pusht
         aicon compare --task pusht --policies aicon sb3 --sb3-path runs/ppo_pusht --out runs/pusht

The same command goes on where a stopped run saved the agent last; with more steps it goes on with a
finished one. Reward, actions, observations and the folder are described in
aicon_baselines/agents/sb3/.
"""

import argparse
from pathlib import Path

from aicon_baselines.agents.registry import import_sb3
from aicon_baselines.cli.command_line import Command, add_option, run_command


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what is trained, and how."""
    parser.add_argument("--task", required=True, help="name of the task, nav2d or pusht")
    add_option(parser, "--algorithm", "ppo", "ppo or sac")
    add_option(parser, "--steps", 1_000_000, "steps in all")
    parser.add_argument("--out", type=Path, required=True, help="folder of the agent")
    add_option(parser, "--checkpoint", 50_000, "steps between saves")
    parser.add_argument("--seed", type=int, help="seed, 1000 or more (default: 10000)")


def run(arguments: argparse.Namespace) -> None:
    """Train what is missing and say what to do with it."""
    sb3 = import_sb3()
    config = sb3.TrainingConfig.for_task(
        arguments.task, arguments.algorithm, arguments.steps, seed=arguments.seed
    )

    trained = sb3.train(config, arguments.out, arguments.checkpoint, report=print)

    print(f"{trained.steps:,} steps, saved in {arguments.out}; to compare it:")
    print(
        f"aicon compare --task {config.task} --policies aicon sb3 --sb3-path {arguments.out} "
        f"--out runs/{config.task}"
    )


COMMAND = Command(
    __doc__, add_arguments, run, "stopped; the same command goes on from the last checkpoint"
)

if __name__ == "__main__":
    run_command(COMMAND)
