"""How long a policy still moves when its readings go wrong for ever, and whether it collides then.

Prints for each fault the longest time from its onset to the last command that is not rest, and how
many of the episodes that it met ended in a collision. Other faults may come with it, after a plus.

Example: python scripts/standing.py --task nav2d --faults gone gone+late --episodes 350 --seed 60000
"""

import argparse
from itertools import islice

import numpy as np
import torch
from numpy.typing import NDArray

from aicon_baselines.cli.command_line import Command, add_option, at_least, run_command
from aicon_baselines.evaluation.config import configure
from aicon_baselines.evaluation.episodes import run_episodes
from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.evaluation.task import Task
from aicon_baselines.tasks import load
from aicon_baselines.tasks.faults import at_once, disturbed
from aicon_torch import Policy, make_policy

FAULTS = ("gone", "stuck", "erratic")
"""What goes wrong for ever; what is stuck is watched for as long as it is."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare whose readings go wrong, and for how long."""
    parser.add_argument("--task", choices=("nav2d", "pusht", "arm_push"), required=True)
    parser.add_argument(
        "--faults",
        nargs="+",
        metavar="NAME",
        default=FAULTS,
        help=f"conditions with one of {', '.join(FAULTS)} (default: each alone)",
    )
    add_option(parser, "--episodes", 20, "per fault", type=at_least(1))
    add_option(parser, "--seed", 1000, "first seed", type=at_least(0))
    add_option(parser, "--horizon", 1200, "steps", type=at_least(1))


def run(arguments: argparse.Namespace) -> None:
    """Run the episodes and say how they went."""
    torch.set_num_threads(1)
    task = load(arguments.task)
    seeds = range(arguments.seed, arguments.seed + arguments.episodes)
    for fault in arguments.faults:
        check_fault(task, fault)
    for fault in arguments.faults:
        policy = make_policy(task.name, **task.policy_options(fault)).compile()
        times, collisions = rest(policy, task, fault, list(seeds), arguments.horizon)
        longest = times.max(initial=0) * task.time_step
        print(
            f"{task.name}, {fault}: {len(times)} episodes, at rest {longest:.2f} s after the "
            f"onset, {collisions} collisions",
            flush=True,
        )


def check_fault(task: Task, fault: str) -> None:
    """Refuse what is no condition of a task, or none in which readings go wrong for ever."""
    configure(task, conditions=[fault])
    if not set(at_once(fault)) & set(FAULTS):
        raise ComparisonError(f"{fault!r} passes; expected one of {', '.join(FAULTS)} in it")


def rest(
    policy: Policy, task: Task, fault: str, seeds: list[int], horizon: int
) -> tuple[NDArray[np.int64], int]:
    """Run episodes until the horizon; those that end before the fault begins do not count.

    Returns:
        From the onset of the fault to the end of the last command that is not rest, ``(N,)``, in
        the environment's steps, of the episodes that it met; and how many of them collided.
    """
    episodes = [task.episode(seed) for seed in seeds]
    env = task.make_env(len(episodes), fault, horizon)
    start = env.reset(**task.reset_arguments(episodes))
    wrong = disturbed(env, next(name for name in FAULTS if name in at_once(fault)))

    met, collided = np.zeros((2, len(episodes)), bool)
    times: NDArray[np.int64] = np.zeros(len(episodes), np.int64)
    since = wrong.since.copy()

    for step in islice(run_episodes(policy, env, start), horizon):
        is_met = step.running & (since >= 0)
        moves = is_met & (since < wrong.pause) & (step.memory["a"] != 0).any(-1).numpy()

        # What it does in this step, it does to its end.
        times = np.where(moves, wrong.since, times)
        met |= is_met
        collided |= is_met & np.asarray(step.info["collision"], bool)

        since = wrong.since.copy()
        if (since >= wrong.pause).all():
            break
    env.close()
    return times[met], int(collided.sum())


COMMAND = Command(__doc__, add_arguments, run)

if __name__ == "__main__":
    run_command(COMMAND)
