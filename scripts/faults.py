"""Run a policy under every fault of a task, and print the table: success, collisions, time.

Faults of which a policy is told the same are stepped as one batch with one compiled policy: several
times faster than `aicon compare --conditions late jitter ...`, and the same but for rounding.

Example: python scripts/faults.py --task nav2d --episodes 100 --seed 60000
"""

import argparse
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from aicon_baselines.agents.registry import make
from aicon_baselines.cli.command_line import Command, run_command
from aicon_baselines.evaluation.task import Episode, Task
from aicon_baselines.tasks import load
from aicon_baselines.tasks.faults import FAULTS

Readings = dict[str, NDArray[Any]]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the faults and the episodes."""
    parser.add_argument("--task", required=True)
    parser.add_argument("--conditions", nargs="+", help="by default the usual one and all faults")
    parser.add_argument("--episodes", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1000)
    parser.add_argument("--horizon", type=int, help="steps; by default the task's")


def run(arguments: argparse.Namespace) -> None:
    """Run the groups of faults one after the other."""
    torch.set_num_threads(1)
    task = load(arguments.task)
    horizon = arguments.horizon or task.horizon
    seeds = range(arguments.seed, arguments.seed + arguments.episodes)
    episodes = [task.episode(seed) for seed in seeds]

    print("| condition | success | collisions | median time |\n|---|---|---|---|")
    for conditions in grouped(task, arguments.conditions or (task.conditions[0], *FAULTS)):
        for row in run_group(task, conditions, episodes, horizon):
            print(row, flush=True)


def grouped(task: Task, conditions: Sequence[str]) -> Iterator[list[str]]:
    """The conditions of which a policy is told the same."""
    groups: dict[str, list[str]] = {}
    for condition in conditions:
        told = repr(sorted(task.policy_options(condition).items()))
        groups.setdefault(told, []).append(condition)
    yield from groups.values()


def run_group(
    task: Task, conditions: Sequence[str], episodes: list[Episode], horizon: int
) -> Iterator[str]:
    """A row of the table for each condition."""
    policy: Any = make(task.name, "aicon", conditions[0])
    policy = policy.compile()
    environments = [task.make_env(len(episodes), name, horizon) for name in conditions]
    results = [env.reset(**task.reset_arguments(episodes)) for env in environments]
    observations = [observation for observation, _ in results]

    count, rows = len(episodes), len(episodes) * len(conditions)
    success, collision = np.zeros(rows, bool), np.zeros(rows, bool)
    steps, running, memory = np.zeros(rows, int), np.ones(rows, bool), None

    # All conditions as one batch; an episode that has ended begins afresh in every step.
    for _ in range(horizon):
        action, memory = policy.predict(together(observations, count), memory, ~running)
        parts = np.split(action, len(conditions))
        stepped = [env.step(part) for env, part in zip(environments, parts, strict=True)]
        observations = [result[0] for result in stepped]

        steps += running
        success |= running & joined(stepped, "is_success")
        collision |= running & joined(stepped, "collision")
        ended = np.concatenate([result[2] | result[3] for result in stepped])
        running &= ~ended
        if not running.any():
            break

    for index, name in enumerate(conditions):
        own = slice(index * count, (index + 1) * count)
        solved = success[own]
        median = np.median(steps[own][solved]) if solved.any() else np.nan
        yield (
            f"| `{name}` | {solved.sum()}/{count} | {collision[own].sum()} | "
            f"{task.duration(int(median)) if solved.any() else '-'} |"
        )


def together(observations: Sequence[Readings], count: int) -> Readings:
    """Observations as one batch; NaN, no reading, where one of them lacks a key."""
    found: Readings = {}
    examples = {key: value for own in observations for key, value in own.items()}
    for key, example in examples.items():
        absent = np.full((count, *example.shape[1:]), np.nan)
        found[key] = np.concatenate([own.get(key, absent) for own in observations])
    return found


def joined(stepped: Sequence[Any], key: str) -> NDArray[np.bool_]:
    """What the infos of the environments say."""
    return np.concatenate([result[4][key] for result in stepped])


COMMAND = Command(__doc__, add_arguments, run)

if __name__ == "__main__":
    run_command(COMMAND)
