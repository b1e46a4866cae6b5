"""A film of an arm that reaches among five moving balls.

Example: python scripts/balls_film.py --seed 1003 --out runs/reach/balls.webp
"""

import argparse

from aicon_baselines.cli.command_line import Command, add_option, at_least, run_command
from aicon_baselines.tasks.reach import TASK
from film import add_film

CONDITION = "ur5_pose_home_five_balls"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what is shown, and where it is saved."""
    add_option(parser, "--seed", 1003, "of the episode", type=at_least(0))
    add_film(parser, "runs/reach/balls.webp")


def run(arguments: argparse.Namespace) -> None:
    """Let the arm reach, and film it."""
    from aicon_baselines.figures.reach import ReachRollout, record_reach
    from aicon_baselines.figures.rollout import draw_film

    recording = record_reach(CONDITION, arguments.seed, TASK.horizon)
    draw_film(ReachRollout(recording), arguments.out)
    print(f"saved {arguments.out}")


COMMAND = Command(__doc__, add_arguments, run)

if __name__ == "__main__":
    run_command(COMMAND)
