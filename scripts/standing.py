"""How long a policy still moves when its readings go wrong for ever, and whether it collides then.

Prints for each fault the longest time from its onset to the last command that is not rest, and how
many of the episodes that it met ended in a collision.

Example: python scripts/standing.py --task nav2d --episodes 350 --seed 60000 --horizon 1200
"""

import argparse
import dataclasses
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from aicon_baselines.cli.command_line import Command, run_command
from aicon_baselines.evaluation.task import Task
from aicon_baselines.tasks import load
from aicon_torch import Policy, make_policy

FAULTS = ("gone", "stuck", "erratic")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare whose readings go wrong, and for how long."""
    parser.add_argument("--task", choices=("nav2d", "pusht", "panda_push"), required=True)
    parser.add_argument("--faults", nargs="+", choices=FAULTS, default=FAULTS)
    parser.add_argument("--episodes", type=int, default=20, help="per fault (default: 20)")
    parser.add_argument("--seed", type=int, default=1000, help="first seed (default: 1000)")
    parser.add_argument("--horizon", type=int, default=1200, help="steps (default: 1200)")


def run(arguments: argparse.Namespace) -> None:
    """Run the episodes and say how they went."""
    torch.set_num_threads(1)
    task = load(arguments.task)
    options = task.policy_options(arguments.faults[0])
    policy = make_policy(task.name, **options).compile()

    seeds = range(arguments.seed, arguments.seed + arguments.episodes)
    for fault in arguments.faults:
        met = rest(policy, task, fault, list(seeds), arguments.horizon)
        longest = met.times.max() * task.time_step
        print(
            f"{task.name}, {fault}: {len(met.times)} episodes, at rest {longest:.2f} s after the "
            f"onset, {met.collisions} collisions",
            flush=True,
        )


@dataclasses.dataclass(frozen=True)
class Met:
    """The episodes that a fault met.

    Attributes:
        times: Steps from its onset to the last command that is not rest, ``(N,)``.
        collisions: How many of them collided.
    """

    times: NDArray[np.int64]
    collisions: int


def rest(policy: Policy, task: Task, fault: str, seeds: list[int], horizon: int) -> Met:
    """Run episodes until the horizon; those that end before the fault begins do not count."""
    episodes = [task.episode(seed) for seed in seeds]
    env: Any = task.make_env(len(episodes), fault, horizon)
    observation, info = env.reset(**task.reset_arguments(episodes))
    running, collided = np.ones(len(episodes), bool), np.zeros(len(episodes), bool)
    starts, memory = running, None
    last: NDArray[np.intp] = np.full(len(episodes), -1)

    for step in range(min(horizon, int(env.onset.max()) + env.pause)):
        action, memory = policy.predict(observation, memory, starts)
        is_within = (step >= env.onset) & (step < env.onset + env.pause)
        moves = (memory["a"] != 0).any(-1).numpy()
        last = np.where(is_within & moves & running, step, last)

        observation, _, terminated, truncated, info = env.step(action)
        is_met = running & (step >= env.onset)
        collided |= is_met & np.asarray(info["collision"], bool)
        running = running & ~(terminated | truncated)
        starts = np.zeros(len(episodes), bool)
    env.close()

    met = (last >= env.onset) | running | collided
    times = np.where(last >= env.onset, last - env.onset + 1, 0)
    return Met(times[met], int(collided.sum()))


COMMAND = Command(__doc__, add_arguments, run)

if __name__ == "__main__":
    run_command(COMMAND)
