"""How much room a target of reaching leaves: why an arm that keeps off itself does not come to it.

The solutions of inverse kinematics are sought by least squares from random postures within the
stops. At each of them the policy's own capsules are some distance apart; where the largest is less
than the margin that they keep, the policy has no place to go to.

Example: python scripts/reach_room.py --condition ur5_pose_home --seeds 16 67
"""

import argparse
import math

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.optimize import least_squares
from torch import Tensor

from aicon_baselines.cli.command_line import Command, add_option, at_least, run_command
from aicon_baselines.evaluation.recording import track
from aicon_baselines.tasks.reach import TASK
from aicon_envs.reach.robots import draw_postures
from aicon_torch.models.reach import Options
from aicon_torch.parts import Robot, TipPose
from reach_study import room, targets

MARGIN, SOLVED = 0.02, 1e-4  # rad that stay to a stop; m, and rad times 1 m, that may be missing

Array = NDArray[np.float64]


def solutions(robot: Robot, pose: TipPose, target: Tensor, starts: int) -> list[Array]:
    """Postures at a target ``(size,)``, found from random ones; some are found more than once."""

    def missing(q: Array) -> Array:
        away: Array = (pose.of_frame(robot.chain(torch.from_numpy(q))) - target).numpy()
        return away

    low, high = robot.chain.low.numpy() + MARGIN, robot.chain.high.numpy() - MARGIN
    found: list[Array] = []
    generator = np.random.default_rng(0)
    for _ in track(range(starts), "solutions"):
        (start,) = draw_postures(low, high, 1, generator)
        solved = least_squares(missing, start, bounds=(low, high))
        if np.linalg.norm(solved.fun) < SOLVED:
            found.append(solved.x)
    return found


def run(arguments: argparse.Namespace) -> None:
    """Say how much room each target leaves."""
    torch.set_num_threads(1)
    robot, pose, _, places = targets(arguments.condition, arguments.seeds)
    for seed, target in zip(arguments.seeds, places, strict=True):
        found = solutions(robot, pose, target, arguments.starts)
        rooms = [float(room(robot, torch.from_numpy(q))) for q in found]
        print(
            f"{seed}: of {arguments.starts} starts {len(found)} come there; capsules are "
            f"{1e3 * max(rooms, default=math.nan):.1f} mm apart at most, and keep "
            f"{1e3 * Options().self_collision.margin:.1f} mm"
        )


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare which targets."""
    parser.add_argument(
        "--condition", choices=TASK.conditions, required=True, metavar="NAME", help="of the targets"
    )
    parser.add_argument("--seeds", nargs="+", type=int, required=True, metavar="SEED")
    add_option(parser, "--starts", 150, "random postures", type=at_least(1))


COMMAND = Command(__doc__, add_arguments, run)

if __name__ == "__main__":
    run_command(COMMAND)
