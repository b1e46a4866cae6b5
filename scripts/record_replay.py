"""Export a policy, and record an episode of it for the program in C++ to replay.

Example: python scripts/record_replay.py nav2d build/nav2d
"""

import argparse
from pathlib import Path
from typing import Any

import numpy as np

from aicon_baselines.agents.registry import make
from aicon_baselines.cli.bench import record_observations
from aicon_baselines.cli.command_line import Command, run_command
from aicon_baselines.tasks import load, names
from aicon_torch import load_exported
from aicon_torch.control.library import Library

CONDITIONS = {"panda_push": "true_pose"}  # elsewhere the task's first


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the task, the folder and how much to record."""
    parser.add_argument("task", choices=names())
    parser.add_argument("folder", type=Path, help="for policy.so, readings.bin and commands.bin")
    parser.add_argument("--steps", type=int, default=200, help="of the episode (default: 200)")


def run(arguments: argparse.Namespace) -> None:
    """Write policy.so, readings.bin and commands.bin."""
    task, folder = arguments.task, arguments.folder
    folder.mkdir(parents=True, exist_ok=True)
    condition = CONDITIONS.get(task, load(task).conditions[0])
    policy: Any = make(task, "aicon", condition)
    policy.export(folder / "policy.so", task=task, condition=condition)

    # The readings of an episode, one after the other as the library takes them.
    library, exported = Library(folder / "policy.so"), load_exported(folder / "policy.so")
    memory, starts = library.blank(), np.ones((), dtype=np.uint8)
    readings, commands = [], []
    for observation in record_observations(task, condition, arguments.steps):
        readings.append(exported.flat_readings(observation).reshape(-1))
        memory, command = library.run(readings[-1], memory, starts)
        starts = np.zeros((), dtype=np.uint8)
        commands.append(command)

    np.array(readings).tofile(folder / "readings.bin")
    np.array(commands).tofile(folder / "commands.bin")
    print(f"{len(readings)} steps of {task} in {folder}")


COMMAND = Command(__doc__, add_arguments, run)

if __name__ == "__main__":
    run_command(COMMAND)
